// The vertices of a list of splits as a hierarchy, and the front of those that are there: any part of a
// surface can be finer than the rest.
//
// J. Xia, A. Varshney: Dynamic View-Dependent Simplification for Polygonal Models. Visualization 1996 (a
// front that moves from frame to frame). J. El-Sana, A. Varshney: Generalized View-Dependent Simplification.
// Eurographics 1999 (dependencies told by numbers).
//
// A split may be applied when no vertex beside it waits for an earlier one, and taken back when no vertex
// beside it was made by a later one. What is around a split is then what was there when it was recorded.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <algorithm>
#include <concepts>
#include <optional>
#include <queue>
#include <unordered_set>
#include <vector>

namespace recede {

/// The split of `kept` into itself and `removed`. Both k_no_index: something comes back that hangs together
/// with nothing else.
struct VertexPair {
  Index removed = k_no_index, kept = k_no_index;
};

/// Links between splits, which are numbered from the base on.
class VertexHierarchy {
 public:
  VertexHierarchy(std::size_t n_vertices, std::vector<VertexPair> splits);

  std::size_t n_vertices() const { return first_.size(); }
  std::size_t n_splits() const { return splits_.size(); }
  const VertexPair& split(Index split) const { return splits_[split]; }
  /// The first split of a vertex once it is there, or k_no_index, as below.
  Index first(Index vertex) const { return first_[vertex]; }
  /// The next split of the vertex that this one keeps.
  Index following(Index split) const { return following_[split]; }
  /// The split that made the vertex that this one keeps as this one finds it.
  Index preceding(Index split) const { return preceding_[split]; }

 private:
  std::vector<VertexPair> splits_;
  std::vector<Index> first_, following_, preceding_;
};

/// What a front needs of the thing whose vertices it holds. `around_split` visits the vertices beside the one
/// that a split takes apart, or may, and `around_merge` those beside the two that it made; both may visit
/// some twice, and the split's own.
template <typename T>
concept VertexGraph = requires(T graph, const T& same, Index split, void (*visit)(Index)) {
  graph.apply_split(split);
  graph.apply_merge(split);
  same.around_split(split, visit);
  same.around_merge(split, visit);
  /// Whether all that the split needs is there, apart from what is around it.
  { same.is_ready(split) } -> std::convertible_to<bool>;
  /// What is held below a budget.
  { same.size() } -> std::convertible_to<std::size_t>;
};

/// What moving a front took.
struct FrontMoves {
  std::size_t splits = 0;  ///< all of them
  std::size_t forced = 0;  ///< those of them that only others needed
  std::size_t merges = 0;
};

/// The vertices that are there. Starts at the base.
class VertexFront {
 public:
  /// `hierarchy` must live as long as the front.
  explicit VertexFront(const VertexHierarchy& hierarchy);

  bool is_applied(Index split) const { return applied_[split] != 0; }

  /// Visits the splits that are next, and those without vertices that aren't applied.
  template <typename Visit>
  void each_next(Visit&& visit) const {
    for (const Index split : loose_) {
      if (!is_applied(split)) visit(split);
    }
    for (const Member& member : members_) {
      if (member.next != k_no_index) visit(member.next);
    }
  }

  /// Applies exactly the splits that are wanted and those that they need, wherever the front stood before.
  /// `wanted` tells of a split whether it is, and of none whose predecessor (`VertexHierarchy`) isn't.
  template <VertexGraph Graph, std::predicate<Index> Wanted>
  FrontMoves adapt(Graph& graph, Wanted&& wanted);

  /// The same for splits whose priority is above a threshold, the highest first, while `graph.size()` is at
  /// most `budget`; those of lower priority give way. No predecessor may have a lower priority.
  template <VertexGraph Graph, std::invocable<Index> Priority>
  FrontMoves adapt_within(Graph& graph, Priority&& priority, double threshold, std::size_t budget);

 private:
  using Ranked = std::pair<double, Index>;

  /// A vertex that is there. All that a scan of the front needs lies together.
  struct Member {
    Index vertex, next, last;  ///< its next split, and the one that made it as it is; k_no_index: none
    bool was_removed;          ///< by `last`; otherwise it was kept
  };
  Index next(Index vertex) const { return members_[place_[vertex]].next; }
  Index last(Index vertex) const { return members_[place_[vertex]].last; }
  void set_last(Member& member, Index split) {
    member.last = split;
    member.was_removed = split != k_no_index && hierarchy_->split(split).removed == member.vertex;
  }

  /// Applies a split after those that it needs.
  template <VertexGraph Graph, std::invocable<Index> Applied>
  void force(Graph& graph, Index split, FrontMoves& moves, Applied&& applied);
  template <VertexGraph Graph>
  bool may_merge(const Graph& graph, Index split) const;
  template <VertexGraph Graph>
  void merge(Graph& graph, Index split, FrontMoves& moves);
  template <VertexGraph Graph, std::predicate<Index> Wanted>
  void refine(Graph& graph, Wanted&& wanted, FrontMoves& moves);
  template <VertexGraph Graph, std::predicate<Index> Wanted>
  void coarsen(Graph& graph, Wanted&& wanted, FrontMoves& moves);
  template <typename Visit>
  void each_made_here(Visit&& visit) const;
  /// Whether both vertices of a split are as it made them.
  bool is_last(Index split) const;
  void mark_split(Index split);
  void mark_merge(Index split);

  const VertexHierarchy* hierarchy_;
  std::vector<unsigned char> applied_;  // by split
  std::vector<Member> members_;
  std::vector<Index> place_;    // by vertex: among the members; k_no_index: it isn't there
  std::vector<Index> loose_;    // splits without vertices
  std::vector<Index> pending_;  // of `force`
};

template <VertexGraph Graph, std::invocable<Index> Applied>
void VertexFront::force(Graph& graph, Index split, FrontMoves& moves, Applied&& applied) {
  pending_.assign(1, split);
  while (!pending_.empty()) {
    const Index s = pending_.back();
    if (is_applied(s)) {
      pending_.pop_back();
      continue;
    }
    const std::size_t n = pending_.size();
    graph.around_split(s, [&](Index vertex) {
      if (next(vertex) < s) pending_.push_back(next(vertex));
    });
    if (pending_.size() > n) continue;
    pending_.pop_back();
    graph.apply_split(s);
    mark_split(s);
    ++moves.splits;
    if (s != split) ++moves.forced;
    applied(s);
  }
}

template <VertexGraph Graph>
bool VertexFront::may_merge(const Graph& graph, Index split) const {
  if (!is_applied(split) || !is_last(split)) return false;
  const VertexPair& pair = hierarchy_->split(split);
  bool is_free = true;
  graph.around_merge(split, [&](Index vertex) {
    // One more than the last split, so that none counts as the least.
    if (vertex != pair.removed && vertex != pair.kept && last(vertex) + 1 > split) is_free = false;
  });
  return is_free;
}

template <VertexGraph Graph>
void VertexFront::merge(Graph& graph, Index split, FrontMoves& moves) {
  graph.apply_merge(split);
  mark_merge(split);
  ++moves.merges;
}

template <VertexGraph Graph, std::predicate<Index> Wanted>
void VertexFront::refine(Graph& graph, Wanted&& wanted, FrontMoves& moves) {
  const auto nothing = [](Index) {};
  for (const Index split : loose_) {
    if (!is_applied(split) && wanted(split)) force(graph, split, moves, nothing);
  }
  // Vertices that come are added at the end.
  for (std::size_t i = 0; i < members_.size(); ++i) {
    while (members_[i].next != k_no_index && wanted(members_[i].next) && graph.is_ready(members_[i].next)) {
      force(graph, members_[i].next, moves, nothing);
    }
  }
}

/// Visits the splits that made a vertex as it is and might be taken back, each once.
template <typename Visit>
void VertexFront::each_made_here(Visit&& visit) const {
  for (const Index split : loose_) {
    if (is_applied(split)) visit(split);
  }
  for (const Member& member : members_) {
    if (member.was_removed) visit(member.last);
  }
}

/// The latest first: what could stand in a split's way has then been looked at.
template <VertexGraph Graph, std::predicate<Index> Wanted>
void VertexFront::coarsen(Graph& graph, Wanted&& wanted, FrontMoves& moves) {
  std::priority_queue<Index> unwanted;
  each_made_here([&](Index split) {
    if (!wanted(split)) unwanted.push(split);
  });
  while (!unwanted.empty()) {
    const Index split = unwanted.top();
    unwanted.pop();
    if (!may_merge(graph, split)) continue;
    merge(graph, split, moves);
    const Index before = hierarchy_->preceding(split);
    if (before != k_no_index && is_last(before) && !wanted(before)) unwanted.push(before);
  }
}

template <VertexGraph Graph, std::predicate<Index> Wanted>
FrontMoves VertexFront::adapt(Graph& graph, Wanted&& wanted) {
  FrontMoves moves;
  refine(graph, wanted, moves);
  coarsen(graph, wanted, moves);
  return moves;
}

template <VertexGraph Graph, std::invocable<Index> Priority>
FrontMoves VertexFront::adapt_within(Graph& graph, Priority&& priority, double threshold,
                                     std::size_t budget) {
  FrontMoves moves;
  coarsen(
      graph, [&](Index split) { return priority(split) > threshold; }, moves);
  std::priority_queue<Ranked> wanted;
  std::priority_queue<Ranked, std::vector<Ranked>, std::greater<>> applied;
  std::unordered_set<Index> given_up;  // may come back for others, but not for their own sake
  const auto want = [&](Index split) {
    if (split == k_no_index || is_applied(split) || !graph.is_ready(split) || given_up.contains(split))
      return;
    if (const double p = priority(split); p > threshold) wanted.emplace(p, split);
  };
  const auto offer = [&](Index split) {
    if (split != k_no_index && is_applied(split) && is_last(split)) applied.emplace(priority(split), split);
  };
  each_next(want);
  each_made_here(offer);
  // The lowest priority that can give way; what can't now is offered again when something beside it goes.
  const auto lowest = [&] {
    while (!applied.empty() && !may_merge(graph, applied.top().second)) applied.pop();
    return applied.empty() ? std::optional<double>() : applied.top().first;
  };
  const auto give_way = [&] {
    while (graph.size() > budget) {
      if (!lowest()) {
        for (const Index split : loose_) offer(split);  // nothing beside them goes
        if (!lowest()) return;
      }
      const Index split = applied.top().second;
      applied.pop();
      merge(graph, split, moves);
      given_up.insert(split);
      offer(hierarchy_->preceding(split));
      graph.around_split(split, [&](Index vertex) { offer(last(vertex)); });
    }
  };
  give_way();
  constexpr std::size_t k_faces_per_split = 2;
  while (!wanted.empty()) {
    const auto [p, split] = wanted.top();
    wanted.pop();
    if (is_applied(split) || !graph.is_ready(split) || given_up.contains(split)) continue;
    if (graph.size() + k_faces_per_split > budget && lowest().value_or(p) >= p) break;
    force(graph, split, moves, [&](Index done) {
      const VertexPair& pair = hierarchy_->split(done);
      applied.emplace(priority(done), done);
      if (pair.kept == k_no_index) return;
      want(next(pair.kept));
      want(next(pair.removed));
    });
    give_way();
  }
  return moves;
}

}  // namespace recede
