// How far surfaces are from one that doesn't fit in memory.
#pragma once

#include <recede/lod/detail/chunk_files.h>
#include <recede/lod/lod_hierarchy.h>

namespace recede::detail {

/// Two-sided distances of each level to all of `input`, as `measure_distance` gives them; bounds are proved.
/// `points` are some of the input, from which first guesses come. `options.limit` is ignored.
std::vector<LevelError> measure_against_chunks(const ChunkFiles& input, const std::vector<Vec3>& points,
                                               const std::vector<PolygonSoup>& levels,
                                               const DistanceOptions& options, Progress* progress);

}  // namespace recede::detail
