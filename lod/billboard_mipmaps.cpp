#include <recede/lod/billboard_mipmaps.h>
#include <recede/lod/detail/billboard_texels.h>
#include <recede/lod/detail/masked_area.h>

#include <algorithm>

namespace recede {

namespace {

using Values = detail::TexelValues;

struct Level {
  int width = 0, height = 0;
  std::vector<float> opacity;
  std::vector<Values> values;
};

Level level_of(const BillboardTextures& textures) {
  Level level{textures.color.width, textures.color.height, {}, {}};
  const std::size_t n = textures.height.samples.size();
  for (std::size_t i = 0; i < n; ++i) {
    level.values.push_back(detail::texel_values(textures.color, textures.normal, textures.height, i,
                                                level.opacity.emplace_back()));
  }
  return level;
}

Level half_of(const Level& from) {
  Level to{std::max(1, from.width / 2), std::max(1, from.height / 2), {}, {}};
  for (int y = 0; y < to.height; ++y) {
    for (int x = 0; x < to.width; ++x) {
      float opacity = 0;
      Values sum = Values::Zero(), plain = Values::Zero();
      for (int k = 0; k < 4; ++k) {
        const auto column = static_cast<std::size_t>(std::min(2 * x + k % 2, from.width - 1)),
                   row = static_cast<std::size_t>(std::min(2 * y + k / 2, from.height - 1));
        const std::size_t texel = row * static_cast<std::size_t>(from.width) + column;
        opacity += from.opacity[texel] / 4;
        sum += from.opacity[texel] * from.values[texel];
        plain += from.values[texel];
      }
      to.opacity.push_back(opacity);
      to.values.push_back(opacity > 0 ? Values(sum / (4 * opacity)) : Values(plain / 4));
    }
  }
  return to;
}

BillboardMipmap mipmap_of(const Level& level, double area) {
  BillboardMipmap mipmap;
  detail::BillboardRasters rasters{mipmap.color, mipmap.normal, mipmap.height};
  rasters.start(level.width, level.height);
  const std::vector<float> opacity = detail::with_masked_area(level.opacity, level.width, level.height, area);
  for (std::size_t i = 0; i < level.values.size(); ++i) rasters.append(level.values[i], opacity[i]);
  return mipmap;
}

}  // namespace

std::vector<BillboardMipmap> billboard_mipmaps(const BillboardTextures& textures, int n_levels) {
  Level level = level_of(textures);
  const double drawn =
      detail::masked_area(level.opacity, level.width, level.height) / level.width / level.height;
  std::vector<BillboardMipmap> mipmaps;
  for (int k = 0; k < n_levels && std::max(level.width, level.height) > 1; ++k) {
    level = half_of(level);
    mipmaps.push_back(mipmap_of(level, drawn * level.width * level.height));
  }
  return mipmaps;
}

}  // namespace recede
