#include <recede/geometry/shading_normals.h>
#include <recede/lod/detail/surface_attributes.h>

namespace recede::detail {

SurfaceAttributes::SurfaceAttributes(const PolygonSoup& soup)
    : soup_(soup), triangles_(triangulate(soup, &faces_, &corners_)) {
  normals_ = shading_normals(soup, k_crease_angle);
  for (std::size_t c = 0; c < soup.corner_normals.size(); ++c) {
    const Vec3 own = soup.corner_normals[c].stableNormalized();
    if (!own.isZero(0)) normals_[c] = own;
  }
}

Vec3 SurfaceAttributes::normal_at(const TrianglePlace& place) const {
  Vec3 normal = Vec3::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    normal += place.weights[static_cast<Eigen::Index>(k)] * normals_[corners_[3 * place.triangle + k]];
  return normal.stableNormalized();
}

Vec3 SurfaceAttributes::color_at(const TrianglePlace& place) const {
  const Index material =
      soup_.face_materials.empty() ? k_no_index : soup_.face_materials[faces_[place.triangle]];
  Vec3 color = Vec3::Ones();
  if (material != k_no_index) {
    color = soup_.materials[material].base_color.head<3>();
  } else if (soup_.vertex_colors.empty()) {
    color = Material{}.base_color.head<3>();
  }
  if (soup_.vertex_colors.empty()) return color;
  Vec3 factor = Vec3::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    const Index vertex = soup_.corner_vertices[corners_[3 * place.triangle + k]];
    factor += place.weights[static_cast<Eigen::Index>(k)] * soup_.vertex_colors[vertex].head<3>();
  }
  return color.cwiseProduct(factor);
}

}  // namespace recede::detail
