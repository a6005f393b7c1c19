// What operations on textures that fill a layer once share.
#pragma once

#include <recede/shells/detail/volume_sampler.h>
#include <recede/shells/layer_grid.h>
#include <recede/shells/volume_texture.h>

namespace recede::detail {

/// Throws `InputError` for another size than the grid's, and for a texture that repeats.
void check_filled_once(const VolumeTexture& texture, const LayerGrid& grid);

/// Texels with other opacities.
std::size_t count_changed(const VolumeTexture& before, const VolumeTexture& after);

/// Opacity and colour of a place of `source`; without colours, black.
struct VolumeSample {
  std::uint8_t opacity = 0;
  std::array<std::uint8_t, 3> color{};
};
inline VolumeSample sample_at(const VolumeTexture& source, const Vec3& place) {
  VolumeSample sample{.opacity = opacity_byte(sampled_opacity(source, place))};
  if (!source.colors.empty()) {
    const Vec3 color = volume_cell(source.size, source.is_periodic, place).blend([&](std::size_t texel) {
      return number_of(source.colors[texel]);
    });
    sample.color = color_bytes(color / 255);
  }
  return sample;
}

}  // namespace recede::detail
