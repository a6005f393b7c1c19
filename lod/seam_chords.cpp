#include <recede/lod/detail/edge_sampling.h>
#include <recede/lod/detail/plane_hulls.h>
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
               [&](Index at) { width = std::max(width, static_cast<double>(graph.slots[at].width)); });
  return points.size() == 2 ? width : width + strip_width(surface, points, points.front(), points.back());
}

SeamChords::SeamChords(const SeamGraph& graph, std::span<const PatchSurface> surfaces,
                       const ActiveLoops& loops)
    : graph_(&graph),
      surfaces_(surfaces),
      loops_(&loops),
      patch_of_loop_(graph.patches_of_loops()),
      chords_(graph.slots.size()) {
  for (std::size_t slot = 0; slot < chords_.size(); ++slot) remember(static_cast<Index>(slot));
}

SeamChord SeamChords::from(Index slot) const {
  const PatchSurface& surface = surfaces_[patch_of(slot)];
  points_to_next(*graph_, *loops_, slot, points_);
  SeamChord chord;
  for (const Vec2& point : points_) chord.box.extend(point);
  chord.strip = strip_to_next(*graph_, *loops_, slot, points_, surface);
  chord.deviation = surface.bounds.deviation(points_.front(), points_.back());
  return chord;
}

bool SeamChords::stay_simple(std::span<const Index> new_chords,
                             const std::function<bool(Index)>& counts) const {
  for (const Index slot : new_chords) {
    const ParameterBox box = from(slot).box;
    const std::vector<Vec2> hull = hull_of(slot);
    const Index patch = patch_of(slot);
    for (Index l = graph_->patch_loops[patch]; l < graph_->patch_loops[patch + 1]; ++l) {
      const Index start = loops_->first_of(l);
      Index other = start;
      if (!loops_->encloses(l)) {
        if (start == k_no_index || !counts(l)) continue;
        for (Index k = 0; k < loops_->size_of(l); ++k, other = loops_->next(other)) {
          if (hulls_meet(hull, {graph_->slots[other].uv})) return false;
        }
        continue;
      }
      do {
        const bool is_new = std::find(new_chords.begin(), new_chords.end(), other) != new_chords.end();
        if (other != slot && box.intersects(is_new ? from(other).box : chords_[other].box) &&
            meets(slot, hull, other))
          return false;
        other = loops_->next(other);
      } while (other != start);
    }
  }
  return true;
}

bool SeamChords::meets(Index slot, const std::vector<Vec2>& hull, Index other) const {
  const std::vector<Vec2> other_hull = hull_of(other);
  if (loops_->next(slot) == other) return hulls_overlap_beside(hull, other_hull, graph_->slots[other].uv);
  if (loops_->next(other) == slot) return hulls_overlap_beside(hull, other_hull, graph_->slots[slot].uv);
  return hulls_meet(hull, other_hull);
}

std::vector<Vec2> SeamChords::hull_of(Index slot) const {
  std::vector<Vec2> points;
  points_to_next(*graph_, *loops_, slot, points);
  return convex_hull(std::move(points));
}

}  // namespace recede::detail
