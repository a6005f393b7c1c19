#include <recede/lod/detail/triangle_deviation.h>

#include <algorithm>
#include <cmath>

namespace recede::detail {

namespace {

constexpr int k_most_levels = 3;

// The largest deviation at the points that divide the sides of a triangle by `n`, those of `n` / 2 left out.
// All of them: where only some are measured, nothing is known of the rest.
double largest_at(const PatchSurface& surface, const std::array<Vec2, 3>& uvs,
                  const std::array<Vec3, 3>& corners, int n) {
  double largest = 0;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; i + j <= n; ++j) {
      if (i % 2 == 0 && j % 2 == 0) continue;
      const double a = static_cast<double>(i) / n, b = static_cast<double>(j) / n, c = 1 - a - b;
      const Vec2 uv = a * uvs[0] + b * uvs[1] + c * uvs[2];
      const Vec3 on_triangle = a * corners[0] + b * corners[1] + c * corners[2];
      largest = std::max(largest, (surface.shape.evaluate(uv) - on_triangle).norm());
    }
  }
  return largest;
}

std::array<Vec3, 3> corners_of(const PatchSurface& surface, const std::array<Vec2, 3>& uvs) {
  return {surface.shape.evaluate(uvs[0]), surface.shape.evaluate(uvs[1]), surface.shape.evaluate(uvs[2])};
}

}  // namespace

double measured_deviation(const PatchSurface& surface, const std::array<Vec2, 3>& uvs) {
  const std::array<Vec3, 3> corners = corners_of(surface, uvs);
  double largest = 0;
  for (const int n : {2, 4}) largest = std::max(largest, largest_at(surface, uvs, corners, n));
  return largest;
}

double triangle_deviation(const PatchSurface& surface, const std::array<Vec2, 3>& uvs, double enough) {
  const DeviationBound whole = surface.bounds.deviation(uvs, enough);
  if (whole.total() <= enough || enough <= 0) return whole.total();
  // What can't come below it on the last level isn't tried.
  constexpr double k_of_last = 1 << k_most_levels;
  if (whole.bend / (k_of_last * k_of_last) + whole.kink / k_of_last > enough) return whole.total();
  const std::array<Vec3, 3> corners = corners_of(surface, uvs);
  double measured = 0, bend = whole.bend, kink = whole.kink;
  for (int level = 1; level <= k_most_levels; ++level) {
    measured = std::max(measured, largest_at(surface, uvs, corners, 1 << level));
    bend /= 4;
    kink /= 2;
    // Over the small triangles the difference of both triangles is linear, and largest at a corner.
    if (measured > enough || measured + bend + kink <= enough) break;
  }
  return measured + bend + kink;
}

}  // namespace recede::detail
