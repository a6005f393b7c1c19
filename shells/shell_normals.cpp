#include <recede/shells/detail/prism.h>
#include <recede/shells/detail/shell_normals.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace recede::detail {

namespace {

constexpr double k_gain = 1.01;
constexpr double k_exact = 1.005;  // how nearly the longest share is found

double mean_share(const ShellSurface& surface, std::span<const double> thicknesses,
                  std::span<const Vec3> tops) {
  double sum = 0;
  std::size_t n = 0;
  for (std::size_t v = 0; v < tops.size(); ++v) {
    if (surface.normals[v].isZero()) continue;
    sum += (tops[v] - surface.positions[v]).norm() / thicknesses[v];
    ++n;
  }
  return n > 0 ? sum / static_cast<double>(n) : 1;
}

std::vector<Vec3> along_normals(const ShellSurface& surface, std::span<const double> thicknesses,
                                double signed_share) {
  std::vector<Vec3> tops(surface.positions.begin(), surface.positions.end());
  for (std::size_t v = 0; v < tops.size(); ++v) tops[v] += signed_share * thicknesses[v] * surface.normals[v];
  return tops;
}

// Finds out in a hundredth of the time of a check that most surfaces are no candidates.
bool has_inverted(const ShellSurface& surface, std::span<const Vec3> tops, bool is_inward) {
  std::atomic<bool> is_one_inverted{false};
  tbb::parallel_for(std::size_t{0}, surface.triangles.size() / 3, [&](std::size_t t) {
    if (is_one_inverted.load(std::memory_order_relaxed)) return;
    Prism prism;
    for (std::size_t k = 0; k < 3; ++k) {
      const Index v = surface.triangles[3 * t + k];
      prism.bottom[k] = surface.positions[v];
      prism.top[k] = tops[v];
    }
    if (!has_one_orientation(prism, is_inward)) is_one_inverted.store(true, std::memory_order_relaxed);
  });
  return is_one_inverted;
}

}  // namespace

bool stand_on_normals(const ShellSurface& surface, std::span<const double> thicknesses, double side,
                      ShellLayer& layer, Progress* progress) {
  const double least = k_gain * mean_share(surface, thicknesses, layer.tops);
  if (least > 1 || !layer.validity.is_valid()) return false;
  ShellCheckOptions options;
  options.is_inward = side < 0;
  std::vector<Vec3> best;
  const auto succeeds = [&](double share) {
    std::vector<Vec3> tops = along_normals(surface, thicknesses, side * share);
    if (has_inverted(surface, tops, options.is_inward) ||
        !check_shell(surface.positions, tops, surface.triangles, options, progress).is_valid())
      return false;
    best = std::move(tops);
    return true;
  };
  // What is valid at one length is so at all below, which are parts of it.
  if (!succeeds(least)) return false;
  if (!succeeds(1)) {
    double low = least, high = 1;
    while (high > k_exact * low) {
      const double middle = std::sqrt(low * high);
      (succeeds(middle) ? low : high) = middle;
    }
  }
  layer.tops = std::move(best);
  return true;
}

}  // namespace recede::detail
