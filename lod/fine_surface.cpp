#include <recede/lod/detail/fine_surface.h>

#include <algorithm>
#include <cmath>

namespace recede::detail {
namespace {

/// Weights of the corners at a point of a triangle's plane. Triangles without area: the nearest corner.
Vec3 weights_at(const Triangle& triangle, const Vec3& p) {
  const Vec3 normal = (triangle.b - triangle.a).cross(triangle.c - triangle.a);
  const double squared = normal.squaredNorm();
  if (!(squared > 0)) {
    const double distances[3] = {(p - triangle.a).norm(), (p - triangle.b).norm(), (p - triangle.c).norm()};
    return Vec3::Unit(std::min_element(distances, distances + 3) - distances);
  }
  Vec3 weights((triangle.c - triangle.b).cross(p - triangle.b).dot(normal) / squared,
               (triangle.a - triangle.c).cross(p - triangle.c).dot(normal) / squared, 0);
  weights.z() = 1 - weights.x() - weights.y();
  weights = weights.cwiseMax(0.0);
  return weights / weights.sum();
}

}  // namespace

FineSurface::Place FineSurface::over(const MapPlace& point, double reach) const {
  const auto crossing = tree_.nearest_crossing(point.position, point.normal, reach);
  if (crossing.triangle != k_no_index)
    return {{crossing.triangle, crossing.weights}, crossing.distance, false};
  const auto closest = tree_.closest(point.position);
  return {{closest.triangle, weights_at(tree_.triangle(closest.triangle), closest.point)},
          (closest.point - point.position).dot(point.normal),
          true};
}

}  // namespace recede::detail
