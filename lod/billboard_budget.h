// The best billboards for a given memory.
#pragma once

#include <recede/lod/billboard_texture.h>

namespace recede {

/// Bytes that the textures of a cloud would take (`BillboardTextures::bytes`).
std::size_t texture_bytes(const BillboardCloud& cloud, const BillboardTextureOptions& options = {});

/// The cloud of least error whose textures take at most `bytes`, and then as many texels as there is room
/// for. Errors are tried in steps of a fourth of an octave from the model's size down to a thousandth of it
/// (`clouds.errors` is ignored). Throws `OptionError` when not even the coarsest cloud fits; else like
/// `build_billboard_clouds` and `texture_billboards`.
BillboardTextures billboards_within(const PolygonSoup& model, std::size_t bytes,
                                    const BillboardOptions& clouds = {},
                                    const BillboardTextureOptions& textures = {},
                                    Progress* progress = nullptr);

}  // namespace recede
