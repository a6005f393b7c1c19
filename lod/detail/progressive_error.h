// Certified errors for all levels of a progressive mesh.
#pragma once

#include <recede/lod/progressive_mesh.h>

namespace recede::detail {

/// Sets `level_errors` to certified bounds. Some levels are measured against the input. Between two of them
/// every split has a proved bound of the distance between the polygons that it touches before and after
/// (`touched`, by split); these add up where splits follow each other, and the largest sum, on top of the
/// nearer measured level, bounds the level's error by the triangle inequality. A split depends only on those
/// that touched its polygons, so a level gets the smaller of the sums from the finer and from the coarser
/// side, and of the sum from the input on. In the end a running maximum toward the base makes errors
/// monotone.
void prove_level_errors(ProgressiveMesh& mesh, const PolygonSoup& input, const SplitRows<Index>& touched,
                        std::size_t measured_levels, Progress* progress);

}  // namespace recede::detail
