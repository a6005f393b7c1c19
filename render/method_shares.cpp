#include <recede/render/detail/camera_rays.h>
#include <recede/render/detail/seen_surfaces.h>
#include <recede/render/method_shares.h>

namespace recede {

PictureShares count_methods(const Scene& scene, const Camera& camera, const RenderOptions& options) {
  using namespace detail;
  const CameraRays rays(scene.data(), camera);
  const SeenSurfaces surfaces(scene.data(), rays.frame(), options);
  CameraRays::Places middles;
  middles.fill({0.5, 0.5});
  PictureShares shares;
  const double pixel = 1.0 / (static_cast<double>(camera.width) * camera.height);
  RayPacket packet;
  SeenSurfaces::Block seen;
  for (int top = 0; top < camera.height; top += k_packet_side) {
    for (int left = 0; left < camera.width; left += k_packet_side) {
      rays.aim(left, top, middles, packet);
      surfaces.find(packet, seen);
      for (int lane = 0; lane < k_lanes; ++lane) {
        if (left + column_of(lane) >= camera.width || top + row_of(lane) >= camera.height) continue;
        const SeenSurface& surface = seen[static_cast<std::size_t>(lane)];
        double& share = !surface.is_there ? shares.background
                        : surface.transition
                            ? shares.methods[static_cast<std::size_t>(surface.transition->method)]
                            : shares.others;
        share += pixel;
      }
    }
  }
  return shares;
}

}  // namespace recede
