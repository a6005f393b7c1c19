#include <recede/geometry/shading_normals.h>
#include <recede/lod/detail/surface_attributes.h>

#include <array>
#include <cmath>

namespace recede::detail {

SurfaceAttributes::SurfaceAttributes(const PolygonSoup& soup)
    : soup_(soup),
      textures_(soup.corner_uvs.empty() ? std::vector<Material>{} : soup.materials),
      triangles_(triangulate(soup, &faces_, &corners_)) {
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

Vec3 SurfaceAttributes::texture_color(const Texture& texture, const TrianglePlace& place,
                                      double width) const {
  Vec2 uv = Vec2::Zero();
  std::array<Vec2, 3> uvs;
  std::array<Vec3, 3> positions;
  for (std::size_t k = 0; k < 3; ++k) {
    const Index corner = corners_[3 * place.triangle + k];
    uvs[k] = soup_.corner_uvs[corner];
    positions[k] = soup_.positions[soup_.corner_vertices[corner]];
    uv += place.weights[static_cast<Eigen::Index>(k)] * uvs[k];
  }
  if (!(width > 0)) return texture.color_at(uv);
  const Vec2 a = uvs[1] - uvs[0], b = uvs[2] - uvs[0];
  const double in_picture = std::abs(a.x() * b.y() - a.y() * b.x());
  const double in_space = (positions[1] - positions[0]).cross(positions[2] - positions[0]).norm();
  return texture.color_at(uv, in_space > 0 ? width * std::sqrt(in_picture / in_space) : 0);
}

Vec3 SurfaceAttributes::color_at(const TrianglePlace& place, double width) const {
  const Index material =
      soup_.face_materials.empty() ? k_no_index : soup_.face_materials[faces_[place.triangle]];
  Vec3 color = Vec3::Ones();
  if (material != k_no_index) {
    color = soup_.materials[material].base_color.head<3>();
    if (const Texture* texture = textures_.of(material))
      color = color.cwiseProduct(texture_color(*texture, place, width));
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
