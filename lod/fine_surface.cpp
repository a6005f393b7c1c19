#include <recede/geometry/shading_normals.h>
#include <recede/lod/detail/fine_surface.h>

#include <algorithm>
#include <cmath>

namespace recede::detail {
namespace {

constexpr double k_crease_angle = 0.698131700797732;  // 40 degrees, as in pictures

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

FineSurface::FineSurface(const PolygonSoup& soup)
    : soup_(soup), tree_(soup.positions, triangulate(soup, &faces_, &corners_)) {
  normals_ = shading_normals(soup, k_crease_angle);
  for (std::size_t c = 0; c < soup.corner_normals.size(); ++c) {
    const Vec3 own = soup.corner_normals[c].stableNormalized();
    if (!own.isZero(0)) normals_[c] = own;
  }
}

FineSurface::Place FineSurface::over(const MapPlace& point, double reach) const {
  const auto crossing = tree_.nearest_crossing(point.position, point.normal, reach);
  if (crossing.triangle != k_no_index) return {crossing.distance, crossing.triangle, crossing.weights, false};
  const auto closest = tree_.closest(point.position);
  return {(closest.point - point.position).dot(point.normal), closest.triangle,
          weights_at(tree_.triangle(closest.triangle), closest.point), true};
}

Vec3 FineSurface::normal_at(const Place& place) const {
  Vec3 normal = Vec3::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    normal += place.weights[static_cast<Eigen::Index>(k)] * normals_[corners_[3 * place.triangle + k]];
  return normal.stableNormalized();
}

Vec3 FineSurface::color_at(const Place& place) const {
  const Index material =
      soup_.face_materials.empty() ? k_no_index : soup_.face_materials[faces_[place.triangle]];
  Vec3 color = Vec3::Ones();
  if (material != k_no_index) color = soup_.materials[material].base_color.head<3>();
  if (soup_.vertex_colors.empty()) return color;
  Vec3 factor = Vec3::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    const Index vertex = soup_.corner_vertices[corners_[3 * place.triangle + k]];
    factor += place.weights[static_cast<Eigen::Index>(k)] * soup_.vertex_colors[vertex].head<3>();
  }
  return color.cwiseProduct(factor);
}

}  // namespace recede::detail
