#include <recede/render/volume_levels.h>
#include <recede/shells/detail/mipmap_levels.h>

#include <algorithm>
#include <cmath>

namespace recede {

int coarsest_level_seen(const TexturedShell& textured, const VolumeView& view) {
  constexpr int k_most = 32;  // sizes are 2^31 at most
  const PolygonSoup& base = textured.shell->base;
  const ShellLayer& layer = textured.layer();
  const std::array<int, 3>& size = textured.texture->surfaces.front().size;
  double most = 0;  // texels to a pixel
  for (std::size_t c = 0; c + 2 < base.corner_vertices.size(); c += 3) {
    const Index* const v = &base.corner_vertices[c];
    std::array<Vec2, 3> st;
    double distance = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      st[k] = textured.coordinates.of(base.corner_uvs[c + k]);
      distance = std::max(
          {distance, (base.positions[v[k]] - view.eye).norm(), (layer.tops[v[k]] - view.eye).norm()});
    }
    const Vec2 a = st[1] - st[0], b = st[2] - st[0];
    const double texels = std::abs(a.x() * b.y() - a.y() * b.x()) * size[0] * size[1];
    const double area = (base.positions[v[1]] - base.positions[v[0]])
                            .cross(base.positions[v[2]] - base.positions[v[0]])
                            .norm();
    if (area > 0)
      most = std::max(most, view.pixel_angle * distance * std::sqrt(std::max(texels, 1.0) / area));
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
