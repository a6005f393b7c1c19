#include <recede/lod/detail/loop_support.h>

namespace recede::detail {

namespace {

double twice_area_of(std::span<const SeamSlot> loop) {
  double twice = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2 a = loop[i].uv - loop[0].uv, b = loop[(i + 1) % loop.size()].uv - loop[0].uv;
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice;
}

}  // namespace

LoopSupport::LoopSupport(const SeamGraph& graph, std::span<const PatchSurface> surfaces,
                         const ActiveLoops& loops)
    : graph_(&graph), surfaces_(surfaces), loops_(&loops), patch_of_loop_(graph.patches_of_loops()) {
  for (std::size_t l = 0; l < graph.n_loops(); ++l) is_outer_.push_back(twice_area_of(graph.loop(l)) > 0);
}

bool LoopSupport::is_left(Index patch) const {
  bool is = false;
  each_loop(patch, [&](Index l) { is = is || loops_->encloses(l); });
  return is;
}

bool LoopSupport::is_end(Index vertex) const {
  bool is = false;
  loops_->each_slot(vertex, [&](Index slot) { is = is || loops_->encloses(loops_->loop_of(slot)); });
  return is;
}

bool LoopSupport::is_side(Index a, Index b) const {
  bool is = false;
  loops_->each_slot(a, [&](Index slot) {
    is = is || (loops_->encloses(loops_->loop_of(slot)) &&
                (loops_->vertex(loops_->previous(slot)) == b || loops_->vertex(loops_->next(slot)) == b));
  });
  return is;
}

bool LoopSupport::stands_for_patch(Index vertex) const {
  bool does = false;
  loops_->each_slot(vertex,
                    [&](Index slot) { does = does || is_outline_of_vanished(loops_->loop_of(slot)); });
  return does;
}

bool LoopSupport::is_supported(Index vertex) const {
  bool is = is_end(vertex);
  loops_->each_slot(vertex, [&](Index slot) { is = is || is_within_flat_patch(slot); });
  return is;
}

bool LoopSupport::is_within_flat_patch(Index slot) const {
  const Index loop = loops_->loop_of(slot), patch = patch_of_loop_[loop];
  return !is_outer_[loop] && !loops_->encloses(loop) && surfaces_[patch].bend == SurfaceBend::none &&
         loops_->vertex(slot) == graph_->slots[slot].vertex && is_left(patch);
}

bool LoopSupport::may_hold_up(Index loop) const {
  bool may = false;
  loops_->each_slot_of_loop(loop, [&](Index slot) { may = may || is_within_flat_patch(slot); });
  return may;
}

bool LoopSupport::holds_up(Index loop) const {
  if (is_outer_[loop] || loops_->encloses(loop)) return false;
  bool does = false;
  loops_->each_slot_of_loop(loop, [&](Index slot) {
    const Index vertex = loops_->vertex(slot);
    does = does || (stands_for_patch(vertex) && !is_end(vertex));
  });
  return does;
}

bool LoopSupport::may_be_lost(Index loop) const {
  bool is_possible = true;
  if (is_outer_[loop]) {
    is_possible = !is_left(patch_of_loop_[loop]);
    each_loop(patch_of_loop_[loop], [&](Index hole) { is_possible = is_possible && !holds_up(hole); });
  }
  loops_->each_slot_of_loop(loop, [&](Index slot) {
    const Index vertex = loops_->vertex(slot);
    is_possible = is_possible && (is_supported(vertex) || (!is_outer_[loop] && !stands_for_patch(vertex)));
  });
  return is_possible;
}

}  // namespace recede::detail
