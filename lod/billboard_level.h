// Billboard clouds as levels of a hierarchy.
#pragma once

#include <recede/lod/lod_hierarchy.h>

namespace recede {

/// The rectangles of a cloud of `model` as a level: its textures, and what they are off by. Errors are
/// distances between the model and the places that opaque texels stand for, both ways; `bound` is the larger
/// of the greatest that was found and the cloud's error, from which on distances serve. Where no texel is
/// opaque, it is the size of the model. `reason` says why there is this level.
LodLevel billboard_level(const PolygonSoup& model, BillboardTextures textures, std::string reason,
                         Progress* progress = nullptr);

/// Behind the last one. Sets switch distances of all levels.
void append_level(LodHierarchy& hierarchy, LodLevel level);

/// Of clouds alone, finest first: the first serves from everywhere. Throws `OptionError` for none of them and
/// for numbers of the view out of range.
LodHierarchy billboard_hierarchy(const PolygonSoup& model, const std::string& name,
                                 std::vector<BillboardTextures> clouds, const ViewSettings& view = {},
                                 Progress* progress = nullptr);

}  // namespace recede
