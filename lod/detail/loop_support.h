// What patches that are left hold of those that have vanished.
#pragma once

#include <recede/lod/detail/active_loops.h>

#include <span>

namespace recede::detail {

/// Of active loops, as they are at present: a loop of two slots or one encloses nothing any more. A patch of
/// which no loop encloses anything has vanished; its slots are left, at vertices that have to be at patches
/// that are there.
class LoopSupport {
 public:
  /// All must live as long.
  LoopSupport(const SeamGraph& graph, std::span<const PatchSurface> surfaces, const ActiveLoops& loops);

  Index patch_of_loop(Index loop) const { return patch_of_loop_[loop]; }
  Index patch_of_slot(Index slot) const { return patch_of_loop_[loops_->loop_of(slot)]; }
  bool is_outer(Index loop) const { return is_outer_[loop]; }
  bool is_left(Index patch) const;

  /// Of a side of a patch that is left.
  bool is_end(Index vertex) const;
  bool is_side(Index a, Index b) const;

  bool is_outline_of_vanished(Index loop) const { return is_outer_[loop] && !loops_->encloses(loop); }
  bool stands_for_patch(Index vertex) const;
  /// At a side of a patch that is left, or within a flat one.
  bool is_supported(Index vertex) const;
  /// Where a hole of a flat patch has closed, what is left of it is within the patch.
  bool is_within_flat_patch(Index slot) const;
  /// Whether something may vanish on to this closed hole, as long as the patch is around it.
  bool may_hold_up(Index loop) const;
  /// Whether something that vanished is at this closed hole alone.
  bool holds_up(Index loop) const;

  /// Whether a loop may enclose nothing, as it does since the last change: not the outline around a hole, and
  /// nothing without which something that vanished would be at no patch that is left.
  bool may_be_lost(Index loop) const;

 private:
  template <typename Visit>
  void each_loop(Index patch, Visit&& visit) const {
    for (Index l = graph_->patch_loops[patch]; l < graph_->patch_loops[patch + 1]; ++l) visit(l);
  }

  const SeamGraph* graph_;
  std::span<const PatchSurface> surfaces_;
  const ActiveLoops* loops_;
  std::vector<Index> patch_of_loop_;
  std::vector<bool> is_outer_;
};

}  // namespace recede::detail
