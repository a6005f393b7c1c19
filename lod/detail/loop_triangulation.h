// Triangles between the points of a patch's loops.
#pragma once

#include <recede/geometry/constrained_delaunay.h>

namespace recede::detail {

/// What loops go round, to the left of their edges. Throws `InputError` where they cross, run the wrong way
/// around it, or go around nothing.
ConstrainedDelaunay triangulate_loops(std::span<const Vec2> points,
                                      std::span<const std::array<Index, 2>> edges);

}  // namespace recede::detail
