#include <recede/geometry/closest_point.h>
#include <recede/geometry/detail/interval.h>
#include <recede/geometry/error.h>
#include <recede/lod/detail/active_loops.h>
#include <recede/lod/detail/edge_sampling.h>
#include <recede/lod/detail/plane_hulls.h>
#include <recede/lod/patch_tessellator.h>
#include <recede/lod/seam_hierarchy.h>

#include <algorithm>
#include <optional>
#include <queue>

namespace recede {

namespace {

using detail::ActiveLoops;

// A patch is sampled for what it costs to leave it out; the tolerance of this is added to that.
constexpr double k_guard_tolerance = 0.02;  // of the patch's size

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  return (p - closest_point_on_triangle(p, {a, b, b})).norm();
}

class SeamCollapser {
 public:
  SeamCollapser(const SeamGraph& graph, std::span<const PatchSurface> surfaces)
      : graph_(graph),
        surfaces_(surfaces),
        loops_(graph),
        moves_(graph.slots.size()),
        chords_(graph.slots.size()),
        ghosts_(graph.positions.size(), 0.0),
        stamps_(graph.positions.size(), 0),
        refused_(graph.positions.size()),
        guards_(graph.n_patches()) {
    for (std::size_t patch = 0; patch < graph.n_patches(); ++patch) {
      for (std::size_t l = graph.patch_loops[patch]; l < graph.patch_loops[patch + 1]; ++l) {
        patch_of_loop_.push_back(static_cast<Index>(patch));
        is_outer_.push_back(area_of(l) > 0);
      }
    }
    for (std::size_t slot = 0; slot < graph.slots.size(); ++slot) {
      const auto s = static_cast<Index>(slot);
      moves_[slot] = move_of(s, loops_.vertex(s));
      chords_[slot] = chord_from(s);
    }
  }

  SeamHierarchy run(Progress* progress) {
    for (std::size_t v = 0; v < graph_.positions.size(); ++v) queue(static_cast<Index>(v));
    work_off(progress);
    for (std::size_t n_records = 0; n_records < records_.size();) {
      n_records = records_.size();
      queue_refused();
      work_off(progress);
    }
    return finished();
  }

 private:
  void work_off(Progress* progress) {
    while (!heap_.empty()) {
      const Candidate next = heap_.top();
      heap_.pop();
      if (next.stamp != stamps_[next.removed]) continue;
      if (records_.size() % 1024 == 0) {
        report_progress(progress, "collapse",
                        static_cast<double>(records_.size()) / static_cast<double>(graph_.positions.size()));
      }
      if (!collapse(next.removed, next.kept)) {
        refused_[next.removed].push_back(next.kept);
        queue(next.removed);
      }
    }
  }

  // What was in the way may have gone.
  void queue_refused() {
    for (std::size_t v = 0; v < refused_.size(); ++v) queue_if_refused(static_cast<Index>(v));
  }
  void queue_if_refused(Index vertex) {
    if (refused_[vertex].empty()) return;
    refused_[vertex].clear();
    queue(vertex);
  }

  struct Chord {       // from a slot to the next
    double error = 0;  // strip beside it, and the surface's distance along it
    ParameterBox box;
  };
  struct Candidate {
    double error;
    Index removed, kept;
    std::uint32_t stamp;
    bool operator<(const Candidate& other) const {
      return error != other.error ? error > other.error : removed > other.removed;
    }
  };
  struct Record {
    VertexPair pair;
    double error;
    std::size_t first_change;
  };
  struct Trial {
    bool is_possible = false;
    double error = 0;
    double ghost = 0;
  };

  double area_of(std::size_t loop) const {
    const auto slots = graph_.loop(loop);
    double twice = 0;
    for (std::size_t i = 0; i < slots.size(); ++i) {
      const Vec2 &a = slots[i].uv - slots[0].uv, &b = slots[(i + 1) % slots.size()].uv - slots[0].uv;
      twice += a.x() * b.y() - a.y() * b.x();
    }
    return twice / 2;
  }

  Index patch_of(Index slot) const { return patch_of_loop_[loops_.loop_of(slot)]; }
  const Vec3& position(Index vertex) const { return graph_.positions[vertex]; }

  double move_of(Index slot, Index vertex) const {
    return (surfaces_[patch_of(slot)].shape.evaluate(graph_.slots[slot].uv) - position(vertex)).norm();
  }

  // The original slots from one to another of the same loop, both among them.
  template <typename Visit>
  void each_between(Index from, Index to, Visit&& visit) const {
    const Index loop = loops_.loop_of(from), first = graph_.loop_offsets[loop],
                end = graph_.loop_offsets[loop + 1];
    Index slot = from;
    do {
      visit(slot);
      slot = slot + 1 < end ? slot + 1 : first;
    } while (slot != to);
    visit(to);
  }

  Chord chord_from(Index slot) const {
    const Index to = loops_.next(slot);
    const SurfaceBounds& bounds = surfaces_[patch_of(slot)].bounds;
    Chord chord;
    double width = 0;
    points_.clear();
    each_between(slot, to, [&](Index s) {
      points_.push_back(graph_.slots[s].uv);
      chord.box.extend(graph_.slots[s].uv);
      if (s != to) width = std::max(width, static_cast<double>(graph_.widths[s]));
    });
    const Vec2 &a = points_.front(), &b = points_.back();
    if (points_.size() > 2) width += detail::strip_width(bounds, points_, a, b);
    chord.error = width + bounds.deviation(a, b);
    return chord;
  }

  // Carries a collapse out; the changes it made go to `changes_` behind what is there. False, with nothing
  // changed, where a patch would touch itself or lose its outline around a hole.
  bool apply(Index removed, Index kept) {
    const std::size_t first = changes_.size();
    const auto is_beside = [&](Index slot) {
      return loops_.vertex(loops_.previous(slot)) == kept || loops_.vertex(loops_.next(slot)) == kept;
    };
    slots_.clear();
    loops_.each_slot(removed, [&](Index slot) { slots_.push_back(slot); });
    // Dropping one can bring another beside the kept vertex, where a loop has the vertex twice in a row.
    for (bool is_done = false; !is_done;) {
      is_done = true;
      for (Index& slot : slots_) {
        if (slot == k_no_index || !is_beside(slot)) continue;
        drop(slot);
        slot = k_no_index;
        is_done = false;
      }
    }
    bool is_possible = true;
    for (const Index slot : slots_) {
      if (slot == k_no_index) continue;
      bool has_kept = false;
      loops_.each_slot(
          kept, [&](Index other) { has_kept = has_kept || loops_.loop_of(other) == loops_.loop_of(slot); });
      is_possible = is_possible && !has_kept;
    }
    for (std::size_t i = 0; is_possible && i < slots_.size(); ++i) {
      if (slots_[i] == k_no_index) continue;
      loops_.give(slots_[i], kept);
      changes_.push_back(SlotChange::given(slots_[i]));
    }
    // Slots of what encloses nothing any more stay, so that fronts know what hangs together.
    each_lost_loop(
        first, [&](Index loop) { is_possible = is_possible && (!is_outer_[loop] || is_last_loop(loop)); });
    if (!is_possible) undo(first, removed);
    return is_possible;
  }

  // Visits the loops that enclose nothing since the changes from `first` on.
  template <typename Visit>
  void each_lost_loop(std::size_t first, Visit&& visit) const {
    for (std::size_t i = first; i < changes_.size(); ++i) {
      const Index loop = loops_.loop_of(changes_[i].slot());
      if (!changes_[i].is_dropped() || loops_.encloses(loop)) continue;
      Index dropped = 0;  // of this loop, up to here
      bool is_last = true;
      for (std::size_t k = first; k < changes_.size(); ++k) {
        if (!changes_[k].is_dropped() || loops_.loop_of(changes_[k].slot()) != loop) continue;
        ++dropped;
        is_last = is_last && k <= i;
      }
      if (is_last && loops_.size_of(loop) + dropped >= detail::ActiveLoops::k_least_slots) visit(loop);
    }
  }

  void drop(Index slot) {
    loops_.drop(slot);
    changes_.push_back(SlotChange::dropped(slot));
  }

  void undo(std::size_t first, Index removed) {
    while (changes_.size() > first) {
      const SlotChange change = changes_.back();
      changes_.pop_back();
      if (change.is_dropped()) {
        loops_.restore(change.slot());
      } else {
        loops_.give(change.slot(), removed);
      }
    }
  }

  bool is_last_loop(Index loop) const {
    const Index patch = patch_of_loop_[loop];
    for (Index l = graph_.patch_loops[patch]; l < graph_.patch_loops[patch + 1]; ++l) {
      if (l != loop && loops_.encloses(l)) return false;
    }
    return true;
  }

  // Slots from which chords begin that the changes from `first` on made anew, and those whose ends moved.
  void collect_chords(std::size_t first) {
    new_chords_.clear();
    moved_chords_.clear();
    for (std::size_t i = first; i < changes_.size(); ++i) {
      const Index slot = changes_[i].slot();
      if (!loops_.encloses(loops_.loop_of(slot))) continue;
      if (changes_[i].is_dropped()) {
        Index before = slot;
        while (!loops_.is_active(before)) before = loops_.previous(before);
        new_chords_.push_back(before);
      } else {
        moved_chords_.push_back(slot);
        moved_chords_.push_back(loops_.previous(slot));
      }
    }
  }

  double end_moves(Index slot, Index kept) const {
    const auto move = [&](Index s) {
      return loops_.vertex(s) == kept && is_given(s) ? move_of(s, kept) : moves_[s];
    };
    return std::max(move(slot), move(loops_.next(slot)));
  }

  bool is_given(Index slot) const {
    return std::find(moved_chords_.begin(), moved_chords_.end(), slot) != moved_chords_.end();
  }

  // With the changes from `first` on in place.
  Trial assess(std::size_t first, Index removed, Index kept) {
    collect_chords(first);
    double seams = 0;
    for (const Index slot : new_chords_)
      seams = std::max(seams, chord_from(slot).error + end_moves(slot, kept));
    for (const Index slot : moved_chords_)
      seams = std::max(seams, chords_[slot].error + end_moves(slot, kept));
    Trial trial{true, seams / k_seam_share, ghosts_[kept]};
    if (ghosts_[removed] > 0) trial.ghost = std::max(trial.ghost, ghosts_[removed] + step(removed, kept));
    each_lost_loop(first, [&](Index loop) {
      const double cost = is_outer_[loop] ? guard(patch_of_loop_[loop], kept) : hole_width(loop);
      trial.ghost = std::max(trial.ghost, cost);
    });
    trial.error = std::max(trial.error, trial.ghost);
    return trial;
  }

  // How far the edges at the vertex are from those that replace them.
  double step(Index removed, Index kept) const {
    double largest = 0;
    loops_.each_neighbour(kept, [&](Index w) {
      largest = std::max(largest, distance_to_segment(position(removed), position(kept), position(w)));
    });
    return largest;
  }

  // How far a patch is from the seams at a vertex of it that is left.
  double guard(Index patch, Index kept) {
    if (!guards_[patch]) sample(patch);
    segments_.clear();
    segments_.push_back(kept);
    loops_.each_neighbour(kept, [&](Index w) { segments_.push_back(w); });
    double largest = 0;
    const std::vector<Vec3>& corners = guards_[patch]->corners;
    for (std::size_t i = 0; i < corners.size(); i += 3) {
      double least = std::numeric_limits<double>::infinity();
      for (const Index w : segments_) {
        if (least <= largest) break;  // nothing larger will come of it
        double most = 0;
        for (std::size_t k = i; k < i + 3 && most < least; ++k)
          most = std::max(most, distance_to_segment(corners[k], position(kept), position(w)));
        least = std::min(least, most);
      }
      largest = std::max(largest, least);
    }
    return largest + guards_[patch]->tolerance;
  }

  void sample(Index patch) {
    const PatchSurface& surface = surfaces_[patch];
    PatchTessellationOptions options;
    const double size = surface.bounds.box(surface.shape.domain()).diagonal().norm();
    options.tolerance = std::max(k_guard_tolerance * size, 4 * graph_.tolerance);
    options.most_points = 2000;
    const std::vector<SeamLoop> loops = graph_.loops_of(patch);
    guards_[patch].emplace();
    PatchTriangles triangles;
    try {
      triangles = triangulate_patch(loops, graph_.positions, surface, options);
      guards_[patch]->tolerance = triangles.error_bound;
    } catch (const InputError&) {
      guards_[patch]->tolerance = size;  // bad loops: what they go around is somewhere on the surface
    }
    for (const auto& triangle : triangles.triangles) {
      for (const Index corner : triangle) guards_[patch]->corners.push_back(triangles.positions[corner]);
    }
  }

  // Of all of a loop from its first point, in space: a hole that closes is nowhere farther from its border.
  double hole_width(Index loop) const {
    const auto slots = graph_.loop(loop);
    std::vector<Vec2> points;
    for (const SeamSlot& slot : slots) points.push_back(slot.uv);
    return detail::strip_width(surfaces_[patch_of_loop_[loop]].bounds, points, points[0],
                               points[points.size() / 2]);
  }

  void queue(Index vertex) {
    ++stamps_[vertex];
    Candidate best{std::numeric_limits<double>::infinity(), vertex, k_no_index, stamps_[vertex]};
    neighbours_.clear();
    loops_.each_neighbour(vertex, [&](Index w) {
      if (w != vertex) neighbours_.push_back(w);
    });
    std::sort(neighbours_.begin(), neighbours_.end());
    neighbours_.erase(std::unique(neighbours_.begin(), neighbours_.end()), neighbours_.end());
    const std::vector<Index>& refused = refused_[vertex];
    for (const Index w : neighbours_) {
      if (std::find(refused.begin(), refused.end(), w) != refused.end()) continue;
      const std::size_t first = changes_.size();
      if (!apply(vertex, w)) continue;
      const Trial trial = assess(first, vertex, w);
      undo(first, vertex);
      if (trial.error < best.error) {
        best.error = trial.error;
        best.kept = w;
      }
    }
    if (best.kept != k_no_index) heap_.push(best);
  }

  bool collapse(Index removed, Index kept) {
    const std::size_t first = changes_.size();
    if (!apply(removed, kept)) return false;
    const Trial trial = assess(first, removed, kept);
    if (!stays_simple() || turns_back(removed, kept)) {
      undo(first, removed);
      return false;
    }
    for (std::size_t i = first; i < changes_.size(); ++i) {
      if (!changes_[i].is_dropped()) moves_[changes_[i].slot()] = move_of(changes_[i].slot(), kept);
    }
    for (const Index slot : new_chords_) chords_[slot] = chord_from(slot);
    ghosts_[kept] = trial.ghost;
    spread_ghost(first, removed, kept, trial);
    error_ = std::max(error_, trial.error);
    records_.push_back({{removed, kept}, error_, first});
    requeue(first, kept);
    return true;
  }

  // What lay along an edge that moved, or on both sides of what vanished, lies along edges of neighbours too.
  void spread_ghost(std::size_t first, Index removed, Index kept, const Trial& trial) {
    const double moved = ghosts_[removed] > 0 ? step(removed, kept) : 0;
    loops_.each_neighbour(kept, [&](Index w) {
      if (w != kept && ghosts_[w] > 0 && moved > 0) ghosts_[w] += moved;
    });
    each_lost_loop(first, [&](Index loop) {
      Index slot = loops_.first_of(loop);
      for (Index k = 0; k < loops_.size_of(loop); ++k, slot = loops_.next(slot)) {
        double& ghost = ghosts_[loops_.vertex(slot)];
        ghost = std::max(ghost, trial.ghost);
      }
    });
  }

  // Whether no new chord can meet another one, on this level or on any other that a front can reach: their
  // hulls hold all points that may be between their ends.
  bool stays_simple() {
    for (const Index slot : new_chords_) {
      const Chord chord = chord_from(slot);
      const std::vector<Vec2> hull = hull_of(slot);
      const Index patch = patch_of(slot);
      for (Index l = graph_.patch_loops[patch]; l < graph_.patch_loops[patch + 1]; ++l) {
        if (!loops_.encloses(l)) continue;
        const Index start = loops_.first_of(l);
        Index other = start;
        do {
          if (other != slot && chord.box.intersects(box_of(other)) && meets(slot, hull, other)) return false;
          other = loops_.next(other);
        } while (other != start);
      }
    }
    return true;
  }

  ParameterBox box_of(Index slot) const {
    const bool is_new = std::find(new_chords_.begin(), new_chords_.end(), slot) != new_chords_.end();
    return is_new ? chord_from(slot).box : chords_[slot].box;
  }

  bool meets(Index slot, const std::vector<Vec2>& hull, Index other) const {
    const std::vector<Vec2> other_hull = hull_of(other);
    if (loops_.next(slot) == other)
      return detail::hulls_overlap_beside(hull, other_hull, graph_.slots[other].uv);
    if (loops_.next(other) == slot)
      return detail::hulls_overlap_beside(hull, other_hull, graph_.slots[slot].uv);
    return detail::hulls_meet(hull, other_hull);
  }

  std::vector<Vec2> hull_of(Index slot) const {
    std::vector<Vec2> points;
    each_between(slot, loops_.next(slot), [&](Index s) { points.push_back(graph_.slots[s].uv); });
    return detail::convex_hull(std::move(points));
  }

  // Whether an edge of a patch that takes the kept vertex turns by more than a right angle.
  bool turns_back(Index removed, Index kept) const {
    const Vec3 &from = position(removed), &to = position(kept);
    for (const Index slot : moved_chords_) {
      for (const Index end : {loops_.vertex(slot), loops_.vertex(loops_.next(slot))}) {
        if (end != kept && (position(end) - from).dot(position(end) - to) <= 0) return true;
      }
    }
    return false;
  }

  void requeue(std::size_t first, Index kept) {
    affected_.assign(1, kept);
    loops_.each_neighbour(kept, [&](Index w) { affected_.push_back(w); });
    for (std::size_t i = first; i < changes_.size(); ++i)
      affected_.push_back(loops_.vertex(changes_[i].slot()));
    for (const Index slot : new_chords_) {
      affected_.push_back(loops_.vertex(slot));
      affected_.push_back(loops_.vertex(loops_.next(slot)));
    }
    std::sort(affected_.begin(), affected_.end());
    affected_.erase(std::unique(affected_.begin(), affected_.end()), affected_.end());
    for (const Index vertex : std::vector<Index>(affected_)) {
      refused_[vertex].clear();
      queue(vertex);
    }
    each_lost_loop(first, [&](Index loop) {
      const Index patch = patch_of_loop_[loop];
      for (Index slot = graph_.loop_offsets[graph_.patch_loops[patch]];
           slot < graph_.loop_offsets[graph_.patch_loops[patch + 1]]; ++slot) {
        if (loops_.is_active(slot)) queue_if_refused(loops_.vertex(slot));
      }
    });
  }

  SeamHierarchy finished() const {
    SeamHierarchy result;
    for (std::size_t i = records_.size(); i-- > 0;) {
      const Record& record = records_[i];
      const std::size_t end = i + 1 < records_.size() ? records_[i + 1].first_change : changes_.size();
      result.splits.push_back(record.pair);
      result.errors.push_back(detail::rounded_up(record.error));
      for (std::size_t k = record.first_change; k < end; ++k) result.changes.push_back(changes_[k]);
      result.change_offsets.push_back(static_cast<Index>(result.changes.size()));
    }
    for (const std::vector<Index>& of_vertex : refused_) result.refused += of_vertex.size();
    return result;
  }

  struct Guard {
    std::vector<Vec3> corners;  // of triangles, three each
    double tolerance = 0;
  };

  const SeamGraph& graph_;
  std::span<const PatchSurface> surfaces_;
  ActiveLoops loops_;
  std::vector<double> moves_;  // by slot: from its patch to its vertex
  std::vector<Chord> chords_;  // by active slot
  std::vector<double>
      ghosts_;  // by vertex: how far what vanished is from the edges around, at most; 0: nothing did
  std::vector<std::uint32_t> stamps_;
  std::vector<std::vector<Index>> refused_;  // by vertex: where it can't go
  std::vector<std::optional<Guard>> guards_;
  std::vector<Index> patch_of_loop_;
  std::vector<bool> is_outer_;
  std::vector<SlotChange> changes_;
  std::vector<Record> records_;
  std::priority_queue<Candidate> heap_;
  double error_ = 0;
  // Kept for their memory.
  std::vector<Index> slots_, new_chords_, moved_chords_, neighbours_, affected_, segments_;
  mutable std::vector<Vec2> points_;
};

}  // namespace

SeamHierarchy build_seam_hierarchy(const SeamGraph& graph, std::span<const PatchSurface> surfaces,
                                   Progress* progress) {
  if (surfaces.size() != graph.n_patches())
    throw OptionError("a Seam Graph needs the surfaces of its patches");
  return SeamCollapser(graph, surfaces).run(progress);
}

}  // namespace recede
