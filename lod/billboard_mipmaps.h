// Smaller versions of billboards' textures, of which a test of opacity leaves as much.
#pragma once

#include <recede/lod/billboard_texture.h>

namespace recede {

/// The atlas at half, a quarter ... of its size, from the first on; sides that are odd lose a texel's half.
struct BillboardMipmap {
  Raster color, normal, height;  ///< as in `BillboardTextures`
};

/// At most `n_levels`, down to a texel. A texel is the mean of four, of which those count that are drawn, and
/// its opacity that mean times one number for each level: so that the area with half of it and more, bilinear
/// between texels, stays the same share of the atlas (I. Castano: Computing Alpha Mipmaps. 2010).
std::vector<BillboardMipmap> billboard_mipmaps(const BillboardTextures& textures, int n_levels);

}  // namespace recede
