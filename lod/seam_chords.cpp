#include <recede/lod/detail/edge_sampling.h>
#include <recede/lod/detail/seam_chords.h>

#include <algorithm>

namespace recede::detail {

namespace {

// Calls `visit(slot)` for those from an active one to before the next active one.
template <typename Visit>
void each_to_next(const SeamGraph& graph, const ActiveLoops& loops, Index slot, Visit&& visit) {
  const Index loop = loops.loop_of(slot), first = graph.loop_offsets[loop],
              end = graph.loop_offsets[loop + 1];
  Index at = slot;
  do {
    visit(at);
    at = at + 1 < end ? at + 1 : first;
  } while (at != loops.next(slot));
}

}  // namespace

void points_to_next(const SeamGraph& graph, const ActiveLoops& loops, Index slot, std::vector<Vec2>& points) {
  points.clear();
  each_to_next(graph, loops, slot, [&](Index at) { points.push_back(graph.slots[at].uv); });
  points.push_back(graph.slots[loops.next(slot)].uv);
}

double strip_to_next(const SeamGraph& graph, const ActiveLoops& loops, Index slot,
                     const std::vector<Vec2>& points, const PatchSurface& surface) {
  double width = 0;
  each_to_next(graph, loops, slot,
               [&](Index at) { width = std::max(width, static_cast<double>(graph.widths[at])); });
  return points.size() == 2 ? width : width + strip_width(surface, points, points.front(), points.back());
}

}  // namespace recede::detail
