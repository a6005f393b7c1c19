#include <recede/geometry/detail/interval.h>
#include <recede/geometry/error.h>
#include <recede/lod/detail/edge_sampling.h>
#include <recede/lod/detail/loop_support.h>
#include <recede/lod/detail/seam_chords.h>
#include <recede/lod/detail/vanished_patches.h>
#include <recede/lod/seam_hierarchy.h>

#include <algorithm>
#include <queue>

namespace recede {

namespace {

using detail::ActiveLoops;

class SeamCollapser {
 public:
  SeamCollapser(const SeamGraph& graph, std::span<const PatchSurface> surfaces, double largest_error)
      : graph_(graph),
        surfaces_(surfaces),
        largest_error_(largest_error),
        loops_(graph),
        moves_(graph.slots.size()),
        chords_(graph, surfaces, loops_),
        vanished_(graph, surfaces),
        held_up_(graph.n_patches(), 0.0),
        stamps_(graph.positions.size(), 0),
        refused_(graph.positions.size()),
        support_(graph, surfaces, loops_) {
    for (std::size_t slot = 0; slot < graph.slots.size(); ++slot) {
      const auto s = static_cast<Index>(slot);
      moves_[slot] = move_of(s, loops_.vertex(s));
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
    while (!heap_.empty() && heap_.top().error <= largest_error_) {
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
    std::size_t first_vanished;
  };
  const Vec3& position(Index vertex) const { return graph_.positions[vertex]; }

  double move_of(Index slot, Index vertex) const {
    return (surfaces_[support_.patch_of_slot(slot)].shape.evaluate(graph_.slots[slot].uv) - position(vertex))
        .norm();
  }

  double error_of(Index slot, const detail::SeamChord& chord, Index kept) const {
    const double move = end_moves(slot, kept);
    return std::max(
        detail::seam_error(surfaces_[support_.patch_of_slot(slot)].bend, chord.strip, chord.deviation + move),
        held_up_[support_.patch_of_slot(slot)] + move);
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
    each_lost_loop(first, [&](Index loop) { is_possible = is_possible && support_.may_be_lost(loop); });
    is_possible = is_possible && (!support_.stands_for_patch(kept) || support_.is_supported(kept));
    if (!is_possible) undo(first, removed);
    return is_possible;
  }

  // Patches that have vanished and whose seams the changes from `first` on made or moved go to `moved_`;
  // those of which they took away a side alone, or the last one at an end, to `bared_`.
  void collect_vanished(std::size_t first) {
    moved_.clear();
    bared_.clear();
    for (std::size_t i = first; i < changes_.size(); ++i) {
      const Index loop = loops_.loop_of(changes_[i].slot());
      if (support_.is_outline_of_vanished(loop)) moved_.push_back(loop);
    }
    std::sort(moved_.begin(), moved_.end());
    moved_.erase(std::unique(moved_.begin(), moved_.end()), moved_.end());
    const auto add_bared = [&](Index loop) {
      if (support_.is_outline_of_vanished(loop) && !std::binary_search(moved_.begin(), moved_.end(), loop))
        bared_.push_back(loop);
    };
    each_lost_loop(first, [&](Index lost) {
      loops_.each_slot_of_loop(lost, [&](Index slot) {
        const Index a = loops_.vertex(slot), b = loops_.vertex(loops_.next(slot));
        const bool is_end = support_.is_end(a);
        if (is_end && (a == b || support_.is_side(a, b))) return;
        loops_.each_slot(a, [&](Index other) {
          if (!is_end || loops_.vertex(loops_.next(other)) == b) add_bared(loops_.loop_of(other));
        });
      });
    });
    std::sort(bared_.begin(), bared_.end());
    bared_.erase(std::unique(bared_.begin(), bared_.end()), bared_.end());
  }

  // How far a patch is from what its outline has become: a side of other patches, or one or two points of
  // them.
  double distance_of_vanished(Index loop) {
    const Index slot = loops_.first_of(loop), a = loops_.vertex(slot), b = loops_.vertex(loops_.next(slot));
    const Index patch = support_.patch_of_loop(loop);
    const Vec3 &from = position(a), &to = position(b);
    if (a != b && support_.is_side(a, b)) return vanished_.distance(patch, {{detail::Segment{from, to}}});
    return vanished_.distance(patch, {{detail::Segment{from, from}, detail::Segment{to, to}}});
  }

  // Visits the flat patches whose closed holes a patch that vanished is at alone.
  template <typename Visit>
  void each_support(Index loop, Visit&& visit) const {
    loops_.each_slot_of_loop(loop, [&](Index slot) {
      const Index v = loops_.vertex(slot);
      if (support_.is_end(v)) return;
      loops_.each_slot(v, [&](Index other) {
        if (support_.is_within_flat_patch(other)) visit(support_.patch_of_slot(other));
      });
    });
  }

  // Patches at closed holes of flat ones that the changes from `first` on moved corners of.
  void collect_held_up(std::size_t first) {
    std::vector<Index> supports;
    for (std::size_t i = first; i < changes_.size(); ++i) {
      const Index patch = support_.patch_of_slot(changes_[i].slot());
      if (held_up_[patch] > 0) supports.push_back(patch);
    }
    std::sort(supports.begin(), supports.end());
    supports.erase(std::unique(supports.begin(), supports.end()), supports.end());
    for (const Index patch : supports) {
      for (Index l = graph_.patch_loops[patch]; l < graph_.patch_loops[patch + 1]; ++l) {
        if (!support_.holds_up(l)) continue;
        loops_.each_slot_of_loop(l, [&](Index slot) {
          loops_.each_slot(loops_.vertex(slot), [&](Index other) {
            if (support_.is_outline_of_vanished(loops_.loop_of(other)))
              bared_.push_back(loops_.loop_of(other));
          });
        });
      }
    }
    std::sort(bared_.begin(), bared_.end());
    bared_.erase(std::unique(bared_.begin(), bared_.end()), bared_.end());
  }

  // How far corners of a patch were moved from it.
  double largest_move(Index patch, Index kept) const {
    double largest = 0;
    for (Index l = graph_.patch_loops[patch]; l < graph_.patch_loops[patch + 1]; ++l) {
      if (!loops_.encloses(l)) continue;
      loops_.each_slot_of_loop(l, [&](Index slot) { largest = std::max(largest, move_now(slot, kept)); });
    }
    return largest;
  }

  // The largest distance of those of `moved_` and `bared_`. `is_final`: remembers them.
  double largest_of_vanished(Index kept, double moved_by, std::size_t most_measured, bool is_final) {
    double largest = 0;
    const bool is_measured = moved_.size() + bared_.size() <= most_measured;
    for (const std::vector<Index>* loops : {&moved_, &bared_}) {
      for (const Index loop : *loops) {
        const Index patch = support_.patch_of_loop(loop);
        const Index slot = loops_.first_of(loop);
        const double length =
            (position(loops_.vertex(slot)) - position(loops_.vertex(loops_.next(slot)))).norm();
        // Both ends of a side are as near as it is, but for its length.
        const bool is_new = vanished_.at(patch) == 0;
        const double distance = is_measured || is_new
                                    ? distance_of_vanished(loop)
                                    : vanished_.at(patch) + (loops == &moved_ ? moved_by : length);
        if (is_final) vanished_.set(patch, distance);
        largest = std::max(largest, distance);
        each_support(loop, [&](Index support) {
          largest = std::max(largest, distance + largest_move(support, kept));
          if (is_final) held_up_[support] = std::max(held_up_[support], distance);
        });
      }
    }
    return largest;
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

  // With the changes of a collapse in place that isn't final yet.
  double move_now(Index slot, Index kept) const {
    return loops_.vertex(slot) == kept && is_given(slot) ? move_of(slot, kept) : moves_[slot];
  }
  double end_moves(Index slot, Index kept) const {
    return std::max(move_now(slot, kept), move_now(loops_.next(slot), kept));
  }

  bool is_given(Index slot) const {
    return std::find(moved_chords_.begin(), moved_chords_.end(), slot) != moved_chords_.end();
  }

  // The error of a collapse, with its changes from `first` on in place. `is_final`: it stays.
  double assess(std::size_t first, Index removed, Index kept, bool is_final) {
    collect_chords(first);
    double seams = 0, others = 0;
    for (const Index slot : new_chords_) seams = std::max(seams, error_of(slot, chords_.from(slot), kept));
    for (const Index slot : moved_chords_)
      seams = std::max(seams, error_of(slot, chords_.remembered(slot), kept));
    each_lost_loop(first, [&](Index loop) {
      if (!support_.is_outer(loop)) others = std::max(others, hole_width(loop));
    });
    // Measured again and again at a vertex that stands for many, it would take longer than it is worth.
    constexpr std::size_t k_most_tried = 8, k_most_measured = 256;
    collect_vanished(first);
    const double moved_by = (position(removed) - position(kept)).norm();
    others = std::max(
        others, largest_of_vanished(kept, moved_by, is_final ? k_most_measured : k_most_tried, is_final));
    return std::max(seams, others);
  }

  // Of all of a loop from its first point, in space: a hole that closes is nowhere farther from its border.
  double hole_width(Index loop) const {
    const auto slots = graph_.loop(loop);
    std::vector<Vec2> points;
    for (const SeamSlot& slot : slots) points.push_back(slot.uv);
    return detail::strip_width(surfaces_[support_.patch_of_loop(loop)], points, points[0],
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
      const double error = assess(first, vertex, w, false);
      undo(first, vertex);
      if (error < best.error) {
        best.error = error;
        best.kept = w;
      }
    }
    if (best.kept != k_no_index) heap_.push(best);
  }

  bool collapse(Index removed, Index kept) {
    const std::size_t first = changes_.size();
    if (!apply(removed, kept)) return false;
    collect_chords(first);
    if (!chords_.stay_simple(new_chords_, [&](Index loop) { return support_.may_hold_up(loop); }) ||
        turns_back(removed, kept)) {
      undo(first, removed);
      return false;
    }
    error_ = std::max(error_, assess(first, removed, kept, true));
    for (std::size_t i = first; i < changes_.size(); ++i) {
      if (!changes_[i].is_dropped()) moves_[changes_[i].slot()] = move_of(changes_[i].slot(), kept);
    }
    for (const Index slot : new_chords_) chords_.remember(slot);
    records_.push_back({{removed, kept}, error_, first, bared_at_.size()});
    collect_held_up(first);
    for (const Index loop : bared_) bared_at_.push_back(support_.patch_of_loop(loop));
    requeue(first, kept);
    return true;
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
      const Index patch = support_.patch_of_loop(loop);
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
      const std::size_t end_vanished =
          i + 1 < records_.size() ? records_[i + 1].first_vanished : bared_at_.size();
      for (std::size_t k = record.first_vanished; k < end_vanished; ++k)
        result.vanished.push_back({static_cast<Index>(result.splits.size() - 1), bared_at_[k]});
      result.change_offsets.push_back(static_cast<Index>(result.changes.size()));
    }
    for (const std::vector<Index>& of_vertex : refused_) result.refused += of_vertex.size();
    return result;
  }

  const SeamGraph& graph_;
  std::span<const PatchSurface> surfaces_;
  double largest_error_;
  ActiveLoops loops_;
  std::vector<double> moves_;  // by slot: from its patch to its vertex
  detail::SeamChords chords_;
  detail::VanishedPatches vanished_;
  std::vector<double> held_up_;  // by flat patch: how far what vanished is from points of its closed holes
  std::vector<std::uint32_t> stamps_;
  std::vector<std::vector<Index>> refused_;  // by vertex: where it can't go
  detail::LoopSupport support_;
  std::vector<SlotChange> changes_;
  std::vector<Record> records_;
  std::vector<Index> bared_at_;  // patches, record by record
  std::priority_queue<Candidate> heap_;
  double error_ = 0;
  // Kept for their memory.
  std::vector<Index> slots_, new_chords_, moved_chords_, neighbours_, affected_, moved_, bared_;
};

}  // namespace

SeamHierarchy build_seam_hierarchy(const SeamGraph& graph, std::span<const PatchSurface> surfaces,
                                   const SeamHierarchyOptions& options, Progress* progress) {
  if (!(options.largest_error >= 0)) throw OptionError("the largest error of a hierarchy is at least 0");
  if (surfaces.size() != graph.n_patches())
    throw OptionError("a Seam Graph needs the surfaces of its patches");
  return SeamCollapser(graph, surfaces, options.largest_error).run(progress);
}

}  // namespace recede
