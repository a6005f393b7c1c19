// What operations on textures that fill a layer once share.
#pragma once

#include <recede/shells/detail/volume_sampler.h>
#include <recede/shells/layer_grid.h>
#include <recede/shells/volume_texture.h>

namespace recede::detail {

/// Throws `InputError` for another size than the grid's, and for a texture that repeats.
void check_filled_once(const VolumeTexture& texture, const LayerGrid& grid);

/// Texels with other opacities, of grids of one size.
std::size_t count_changed(const BrickGrid<std::uint8_t>& before, const BrickGrid<std::uint8_t>& after);

using OpacityGrid = BrickGrid<std::uint8_t>;
using ColorGrid = BrickGrid<std::array<std::uint8_t, 3>>;

/// Of a place, as texels hold it.
inline std::uint8_t opacity_byte_at(const VolumeTexture& source, const Vec3& place) {
  return opacity_byte(sampled_opacity(source, place));
}
/// The same of colours, which there must be.
inline std::array<std::uint8_t, 3> color_bytes_at(const VolumeTexture& source, const Vec3& place) {
  const Vec3 color = VolumeCell(source.size, source.is_periodic, place).blend(source.colors, number_of);
  return color_bytes(color / 255);
}

}  // namespace recede::detail
