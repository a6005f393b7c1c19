// What a chord between two active slots stands for.
#pragma once

#include <recede/lod/detail/active_loops.h>

#include <functional>
#include <span>

namespace recede::detail {

/// Parameters of all slots of the graph from an active one to the next active one, both among them.
void points_to_next(const SeamGraph& graph, const ActiveLoops& loops, Index slot, std::vector<Vec2>& points);

/// How far the strip between the trimming curve and the chord reaches in space, at most. `points` as above.
double strip_to_next(const SeamGraph& graph, const ActiveLoops& loops, Index slot,
                     const std::vector<Vec2>& points, const PatchSurface& surface);

struct SeamChord {
  double strip = 0;      ///< how far the trimming curve is from it
  double deviation = 0;  ///< how far the surface along it is
  ParameterBox box;      ///< of all slots that it stands for
};

/// The chords of active loops, remembered while these change.
class SeamChords {
 public:
  /// All must live as long.
  SeamChords(const SeamGraph& graph, std::span<const PatchSurface> surfaces, const ActiveLoops& loops);

  /// From an active slot to the next, as loops are now.
  SeamChord from(Index slot) const;
  /// As it was when it was last remembered.
  const SeamChord& remembered(Index slot) const { return chords_[slot]; }
  void remember(Index slot) { chords_[slot] = from(slot); }

  /// Whether none of some new chords, by their slots, can meet another one of its patch, on this level or on
  /// any other that a front can reach: hulls hold all points that may be between the ends of a chord. The
  /// others are as remembered. Of loops that enclose nothing, those that `counts` names are points to stay
  /// away from.
  bool stay_simple(std::span<const Index> new_chords, const std::function<bool(Index)>& counts) const;

 private:
  Index patch_of(Index slot) const { return patch_of_loop_[loops_->loop_of(slot)]; }
  bool meets(Index slot, const std::vector<Vec2>& hull, Index other) const;
  std::vector<Vec2> hull_of(Index slot) const;

  const SeamGraph* graph_;
  std::span<const PatchSurface> surfaces_;
  const ActiveLoops* loops_;
  std::vector<Index> patch_of_loop_;
  std::vector<SeamChord> chords_;     // by slot
  mutable std::vector<Vec2> points_;  // kept for its memory
};

}  // namespace recede::detail
