#include <recede/geometry/detail/interval.h>
#include <recede/lod/detail/seam_chords.h>
#include <recede/lod/seam_front.h>

#include <algorithm>

namespace recede {

class SeamFront::Impl {
 public:
  Impl(const SeamGraph& graph, const SeamHierarchy& hierarchy)
      : graph_(graph),
        levels_(hierarchy),
        loops_(graph),
        vertices_(graph.positions.size(), hierarchy.splits),
        front_(vertices_),
        patch_of_loop_(graph.patches_of_loops()),
        is_changed_(graph.n_patches(), true) {
    for (std::size_t split = hierarchy.n_splits(); split-- > 0;) apply_merge(static_cast<Index>(split));
  }

  template <typename Tolerance>
  FrontMoves adapt(Tolerance&& tolerance_of) {
    // A vertex can have splits of one patch that wait for earlier ones of others, which tolerate more.
    is_wanted_.assign(levels_.n_splits(), 0);
    for (const auto& [split, patch] : levels_.vanished) {
      if (static_cast<double>(levels_.errors[split]) > tolerance_of(patch)) is_wanted_[split] = 1;
    }
    for (std::size_t split = levels_.n_splits(); split-- > 0;) {
      if (is_wanted_[split] == 0 && is_tolerated(split, tolerance_of)) continue;
      is_wanted_[split] = 1;
      const Index before = vertices_.preceding(static_cast<Index>(split));
      if (before != k_no_index) is_wanted_[before] = 1;
    }
    return front_.adapt(*this, [&](Index split) { return is_wanted_[split] != 0; });
  }

  // What `VertexFront` asks of a graph.
  void apply_split(Index split) {
    const auto changes = levels_.changes_of(split);
    for (std::size_t i = changes.size(); i-- > 0;) {
      if (changes[i].is_dropped()) {
        loops_.restore(changes[i].slot());
      } else {
        loops_.give(changes[i].slot(), levels_.splits[split].removed);
      }
    }
    mark(split);
  }
  void apply_merge(Index split) {
    for (const SlotChange& change : levels_.changes_of(split)) {
      if (change.is_dropped()) {
        loops_.drop(change.slot());
      } else {
        loops_.give(change.slot(), levels_.splits[split].kept);
      }
    }
    mark(split);
  }
  template <typename Visit>
  void around_split(Index split, Visit&& visit) const {
    loops_.each_neighbour(levels_.splits[split].kept, visit);
  }
  template <typename Visit>
  void around_merge(Index split, Visit&& visit) const {
    loops_.each_neighbour(levels_.splits[split].kept, visit);
    loops_.each_neighbour(levels_.splits[split].removed, visit);
  }
  bool is_ready(Index) const { return true; }
  std::size_t size() const { return 0; }

  std::vector<SeamLoop> loops_of(std::size_t patch, const PatchSurface& surface) const {
    std::vector<SeamLoop> result;
    std::vector<Vec2> points;
    for (Index l = graph_.patch_loops[patch]; l < graph_.patch_loops[patch + 1]; ++l) {
      if (!loops_.encloses(l)) continue;
      // The same one, however the front got here.
      Index start = graph_.loop_offsets[l];
      while (!loops_.is_active(start)) ++start;
      SeamLoop loop;
      Index slot = start;
      do {
        detail::points_to_next(graph_, loops_, slot, points);
        const float width =
            points.size() == 2
                ? graph_.slots[slot].width
                : detail::rounded_up(detail::strip_to_next(graph_, loops_, slot, points, surface));
        loop.push_back({graph_.slots[slot].uv, loops_.vertex(slot), width});
        slot = loops_.next(slot);
      } while (slot != start);
      result.push_back(std::move(loop));
    }
    return result;
  }

  bool has_vanished(std::size_t patch) const {
    for (Index l = graph_.patch_loops[patch]; l < graph_.patch_loops[patch + 1]; ++l) {
      if (loops_.encloses(l)) return false;
    }
    return true;
  }

  bool is_applied(std::size_t split) const { return front_.is_applied(static_cast<Index>(split)); }

  std::vector<Index> take_changed() {
    std::vector<Index> result;
    for (std::size_t patch = 0; patch < is_changed_.size(); ++patch) {
      if (is_changed_[patch]) result.push_back(static_cast<Index>(patch));
    }
    std::fill(is_changed_.begin(), is_changed_.end(), false);
    return result;
  }

  std::size_t n_patches() const { return graph_.n_patches(); }

 private:
  template <typename Tolerance>
  bool is_tolerated(std::size_t split, Tolerance&& tolerance_of) const {
    const auto error = static_cast<double>(levels_.errors[split]);
    for (const SlotChange& change : levels_.changes_of(split)) {
      if (error > tolerance_of(patch_of_loop_[loops_.loop_of(change.slot())])) return false;
    }
    return true;
  }

  void mark(Index split) {
    for (const SlotChange& change : levels_.changes_of(split))
      is_changed_[patch_of_loop_[loops_.loop_of(change.slot())]] = true;
  }

  const SeamGraph& graph_;
  const SeamHierarchy& levels_;
  detail::ActiveLoops loops_;
  VertexHierarchy vertices_;
  VertexFront front_;
  std::vector<Index> patch_of_loop_;
  std::vector<bool> is_changed_;
  std::vector<unsigned char> is_wanted_;  // by split; kept for its memory
};

SeamFront::SeamFront(const SeamGraph& graph, const SeamHierarchy& hierarchy)
    : impl_(std::make_unique<Impl>(graph, hierarchy)) {}
SeamFront::SeamFront(SeamFront&&) noexcept = default;
SeamFront& SeamFront::operator=(SeamFront&&) noexcept = default;
SeamFront::~SeamFront() = default;

FrontMoves SeamFront::adapt(std::span<const double> tolerance_of_patch) {
  return impl_->adapt([&](Index patch) { return tolerance_of_patch[patch]; });
}

FrontMoves SeamFront::adapt(double tolerance) {
  return impl_->adapt([&](Index) { return tolerance; });
}

std::vector<SeamLoop> SeamFront::loops_of(std::size_t patch, const PatchSurface& surface) const {
  return impl_->loops_of(patch, surface);
}
bool SeamFront::has_vanished(std::size_t patch) const { return impl_->has_vanished(patch); }

std::size_t SeamFront::n_patches_left() const {
  std::size_t n = 0;
  for (std::size_t patch = 0; patch < impl_->n_patches(); ++patch)
    if (!impl_->has_vanished(patch)) ++n;
  return n;
}

bool SeamFront::is_applied(std::size_t split) const { return impl_->is_applied(split); }
std::vector<Index> SeamFront::take_changed() { return impl_->take_changed(); }

}  // namespace recede
