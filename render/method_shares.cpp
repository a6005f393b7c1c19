#include <recede/render/detail/camera_rays.h>
#include <recede/render/detail/flush_denormals.h>
#include <recede/render/detail/seen_surfaces.h>
#include <recede/render/method_shares.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <functional>

namespace recede {

namespace {

using namespace detail;

constexpr std::size_t k_others = 5, k_background = 6;  // after the methods
// Of pixels: whole numbers, whose sums don't depend on the order.
using Counts = std::array<std::size_t, 7>;

std::size_t kind_of(const SeenSurface& surface) {
  if (!surface.is_there) return k_background;
  return surface.transition ? static_cast<std::size_t>(surface.transition->method) : k_others;
}

// Of packets side by side.
void count_row(const CameraRays& rays, const SeenSurfaces& surfaces, int top, Counts& counts) {
  CameraRays::Places middles;
  middles.fill({0.5, 0.5});
  RayPacket packet;
  SeenSurfaces::Block seen;
  for (int left = 0; left < rays.width(); left += k_packet_side) {
    rays.aim(left, top, middles, packet);
    surfaces.find(packet, seen);
    for (int lane = 0; lane < k_lanes; ++lane) {
      if (left + column_of(lane) < rays.width() && top + row_of(lane) < rays.height())
        ++counts[kind_of(seen[static_cast<std::size_t>(lane)])];
    }
  }
}

}  // namespace

PictureShares count_methods(const Scene& scene, const Camera& camera, const RenderOptions& options) {
  const CameraRays rays(scene.data(), camera);
  const SeenSurfaces surfaces(scene.data(), rays.frame(), options);
  const Counts counts = tbb::parallel_reduce(
      tbb::blocked_range<int>(0, (camera.height + k_packet_side - 1) / k_packet_side), Counts{},
      [&](const tbb::blocked_range<int>& rows, Counts sum) {
        const FlushDenormals flush;
        for (int row = rows.begin(); row < rows.end(); ++row)
          count_row(rays, surfaces, row * k_packet_side, sum);
        return sum;
      },
      [](Counts a, const Counts& b) {
        std::transform(a.begin(), a.end(), b.begin(), a.begin(), std::plus<>());
        return a;
      });
  const auto share = [&](std::size_t kind) {
    return static_cast<double>(counts[kind]) / (static_cast<double>(camera.width) * camera.height);
  };
  PictureShares shares{.others = share(k_others), .background = share(k_background)};
  for (std::size_t method = 0; method < shares.methods.size(); ++method)
    shares.methods[method] = share(method);
  return shares;
}

}  // namespace recede
