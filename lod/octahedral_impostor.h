// Pictures of a model from all around, each with its heights: what games call an octahedral impostor.
#pragma once

#include <recede/lod/billboard_texture.h>

namespace recede {

/// A cloud of `views` x `views` billboards, each for all faces as they look along its normal, and in the
/// plane half-way between the nearest and the farthest of them. Directions are the nodes of a grid over the
/// unfolded octahedron (C. Cigolle et al.: A Survey of Efficient Representations for Independent Unit
/// Vectors. JCGT 2014), 2 to 64 along each side; those at its border occur twice and more. A ray meets only
/// the billboard that faces it best. `error` is half of the largest depth, so
/// `BillboardTextureOptions::texels_per_error` says how many texels this is long. Throws like
/// `build_billboard_clouds`.
BillboardCloud octahedral_impostor(const PolygonSoup& model, int views = 8);

/// Such textures with as small texels as `bytes` hold. Throws `OptionError` where a texel for each view is
/// more.
BillboardTextures octahedral_impostor_within(const PolygonSoup& model, std::size_t bytes, int views = 8,
                                             Progress* progress = nullptr);

/// The number of the node nearest to a direction of any length but 0, of the four around it on the
/// octahedron.
std::size_t octahedral_view(const Vec3& direction, int views);

}  // namespace recede
