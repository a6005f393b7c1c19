#include <recede/geometry/shading_normals.h>
#include <recede/render/detail/surface_look.h>

#include <tbb/parallel_for.h>

namespace recede::detail {

Rgb face_color(const PolygonSoup& soup, Index face) {
  const Index material = soup.face_materials.empty() ? k_no_index : soup.face_materials[face];
  if (material == k_no_index) {
    return soup.vertex_colors.empty() ? Rgb(Material{}.base_color.head<3>().cast<float>()) : Rgb(Rgb::Ones());
  }
  return soup.materials[material].base_color.head<3>().cast<float>();
}

std::vector<Vec3> drawn_normals(const PolygonSoup& soup, double crease_angle) {
  std::vector<Vec3> normals = shading_normals(soup, crease_angle);
  tbb::parallel_for(std::size_t{0}, soup.n_faces(), [&](std::size_t face) {
    const Vec3 area = vector_area(soup, static_cast<Index>(face));
    for (Index c = soup.face_offsets[face]; c < soup.face_offsets[face + 1]; ++c) {
      if (!soup.corner_normals.empty() && !soup.corner_normals[c].isZero(0))
        normals[c] = soup.corner_normals[c];
      if (normals[c].dot(area) < 0) normals[c] = -normals[c];
      normals[c] = normals[c].stableNormalized();
    }
  });
  return normals;
}

}  // namespace recede::detail
