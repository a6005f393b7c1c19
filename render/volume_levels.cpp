#include <recede/render/volume_levels.h>
#include <recede/shells/detail/mipmap_levels.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace recede {

int coarsest_level_seen(const TexturedShell& textured, const VolumeView& view) {
  constexpr int k_most = 32;  // sizes are 2^31 at most
  const PolygonSoup& base = textured.shell->base;
  const ShellLayer& layer = textured.layer();
  const std::array<int, 3>& size = textured.texture->surfaces.front().size;
  const std::size_t n_triangles = base.corner_vertices.size() / 3;
  std::vector<double> farthest(n_triangles, 0);  // places of the layer over each triangle
  for (std::size_t c = 0; c < 3 * n_triangles; ++c) {
    const Index v = base.corner_vertices[c];
    farthest[c / 3] =
        std::max({farthest[c / 3], (base.positions[v] - view.eye).norm(), (layer.tops[v] - view.eye).norm()});
  }
  // Rays see both triangles of a quad as one cell.
  for (const Index t : layer.hexahedra)
    farthest[t] = farthest[t + 1] = std::max(farthest[t], farthest[t + 1]);
  double most = 0;  // texels to a pixel
  for (std::size_t t = 0; t < n_triangles; ++t) {
    const Index* const v = &base.corner_vertices[3 * t];
    const auto st = [&](std::size_t k) { return textured.coordinates.of(base.corner_uvs[3 * t + k]); };
    const Vec2 a = st(1) - st(0), b = st(2) - st(0);
    const double texels = std::abs(a.x() * b.y() - a.y() * b.x()) * size[0] * size[1];
    const double area = (base.positions[v[1]] - base.positions[v[0]])
                            .cross(base.positions[v[2]] - base.positions[v[0]])
                            .norm();
    if (area > 0)
      most = std::max(most, view.pixel_angle * farthest[t] * std::sqrt(std::max(texels, 1.0) / area));
  }
  // Rays take the next coarser level by lot.
  return most > 0 ? std::clamp(static_cast<int>(std::floor(std::log2(most))) + 1, 0, k_most) : 0;
}

TexturedShell with_levels_for(const TexturedShell& textured, const VolumeView& view) {
  TexturedShell result = textured;
  result.texture = std::make_shared<const VolumeMipmap>(
      detail::make_mipmap_to(coarsest_level_seen(textured, view), textured.texture->surfaces.front()));
  return result;
}

}  // namespace recede
