// What a chord between two active slots stands for.
#pragma once

#include <recede/lod/detail/active_loops.h>

namespace recede::detail {

/// Parameters of all slots of the graph from an active one to the next active one, both among them.
void points_to_next(const SeamGraph& graph, const ActiveLoops& loops, Index slot, std::vector<Vec2>& points);

/// How far the strip between the trimming curve and the chord reaches in space, at most. `points` as above.
double strip_to_next(const SeamGraph& graph, const ActiveLoops& loops, Index slot,
                     const std::vector<Vec2>& points, const PatchSurface& surface);

}  // namespace recede::detail
