// Greedy merging of neighbouring clusters, the cheapest pair first. Charts of a surface and the clusters of a
// billboard cloud come from it; what a cluster is and what a merge costs is a policy's business.
#pragma once

#include <recede/geometry/disjoint_sets.h>
#include <recede/geometry/progress.h>

#include <algorithm>
#include <concepts>
#include <limits>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace recede {

/// Owns what belongs to the clusters. A cluster is named by the lowest item in it.
template <class Policy>
concept MergePolicy = requires(Policy& policy, Index lower, Index higher) {
  /// What it costs to merge two neighbouring clusters; infinity (or not a number) refuses. Merges of other
  /// clusters may raise the cost of a pair, or have it refused, but never lower it: a pair that was refused
  /// is asked for again only after one of the two has grown.
  { policy.cost(lower, higher) } -> std::convertible_to<double>;
  /// Makes `higher` a part of `lower`.
  policy.merge(lower, higher);
};

/// A policy may also have a cost that it knows only with more work; then `cost` is at most that. It is asked
/// for before a pair is merged.
template <class Policy>
concept HasFinalCost = requires(Policy& policy, Index lower, Index higher) {
  { policy.final_cost(lower, higher) } -> std::convertible_to<double>;
};

/// A policy may compute the costs of many pairs at once, on several threads.
template <class Policy>
concept HasCostsOfPairs = requires(Policy& policy, std::span<const std::pair<Index, Index>> pairs,
                                   std::span<double> costs) {
  policy.costs(pairs, costs);
};

/// A policy may say how far two clusters are apart, for `AgglomerationOptions::most_neighbours`.
template <class Policy>
concept HasDistance = requires(Policy& policy, Index cluster, Index other) {
  { policy.distance(cluster, other) } -> std::convertible_to<double>;
};

/// A policy with `static constexpr bool k_costs_are_of_pairs_alone = true` promises that a pair's costs stay
/// as long as neither grows. Then none is computed twice.
template <class Policy>
concept HasLastingCosts = requires {
  requires Policy::k_costs_are_of_pairs_alone;
};

struct AgglomerationOptions {
  std::size_t clusters = 1;                                     ///< merge until so many are left
  double cost_limit = std::numeric_limits<double>::infinity();  ///< no merge costs more than this
  /// Of a cluster that has grown: the nearest ones, where the policy knows distances. The others may still
  /// have it among theirs.
  std::size_t most_neighbours = std::numeric_limits<std::size_t>::max();
};

/// The stage of progress in which clusters merge: the share of items that did. Costs come before it.
inline constexpr std::string_view k_merging_clusters = "merging clusters";

enum class AgglomerationStop { cluster_target, cost_limit, no_merge_left };

/// One merge: `absorbed` became part of `kept`, which is the lower of the two.
struct ClusterMerge {
  Index kept, absorbed;
  double cost;
};

/// The merge tree.
struct Agglomeration {
  std::size_t n_items = 0;
  std::vector<ClusterMerge> merges;  ///< in the order in which they were made
  AgglomerationStop reason = AgglomerationStop::no_merge_left;

  std::size_t n_clusters() const { return n_items - merges.size(); }
};

/// The cluster of every item after the first `n_merges` merges: one run gives every level of a hierarchy.
/// Clusters are numbered from 0 in the order of their lowest items.
inline std::vector<Index> clusters_after(const Agglomeration& agglomeration, std::size_t n_merges) {
  DisjointSets sets(agglomeration.n_items);
  for (std::size_t m = 0; m < n_merges; ++m) {
    sets.merge(agglomeration.merges[m].kept, agglomeration.merges[m].absorbed);
  }
  std::vector<Index> clusters(agglomeration.n_items);
  Index next = 0;
  for (Index item = 0; item < agglomeration.n_items; ++item) {
    const Index name = sets.find(item);
    clusters[item] = name == item ? next++ : clusters[name];
  }
  return clusters;
}

namespace detail {

/// The neighbours of a cluster are a linked list in one pool, so that merging two lists takes one step; a
/// link that leads inside or repeats another goes when the list is read next. A cluster's candidates are
/// sorted when it has grown, and only the cheapest of them that may be left is in the queue, which stays
/// small. They count how often their two clusters had grown, and are void once that has changed.
template <MergePolicy Policy>
class Agglomerator {
 public:
  Agglomerator(std::size_t n_items, std::span<const std::pair<Index, Index>> neighbours, Policy& policy,
               const AgglomerationOptions& options)
      : policy_(policy),
        options_(options),
        sets_(n_items),
        lists_(n_items),
        growth_(n_items, 0),
        offers_(n_items),
        links_(2 * neighbours.size()) {
    result_.n_items = n_items;
    seen_.assign(n_items, k_no_index);
    // Backwards, so that lists run in the order of `neighbours`.
    for (std::size_t e = neighbours.size(); e-- > 0;) {
      const auto [a, b] = neighbours[e];
      add_link(static_cast<Index>(2 * e), a, b);
      add_link(static_cast<Index>(2 * e + 1), b, a);
    }
  }

  Agglomeration run(Progress* progress) {
    offer_all(progress);
    while (result_.n_clusters() > options_.clusters) {
      if (result_.merges.size() % 4096 == 0) {
        report_progress(progress, k_merging_clusters,
                        static_cast<double>(result_.merges.size()) / static_cast<double>(result_.n_items));
      }
      Candidate cheapest;
      if (!pop_cheapest(cheapest)) {
        result_.reason = AgglomerationStop::no_merge_left;
        return std::move(result_);
      }
      if (cheapest.cost > options_.cost_limit) {
        result_.reason = AgglomerationStop::cost_limit;
        return std::move(result_);
      }
      merge(cheapest);
    }
    result_.reason = AgglomerationStop::cluster_target;
    return std::move(result_);
  }

 private:
  struct List {
    Index first = k_no_index, last = k_no_index;
  };
  struct Link {
    Index item, next;
  };
  struct Candidate {
    double cost;
    Index lower, higher;
    Index growth;               // of both together when the cost was computed
    Index source = k_no_index;  // the cluster whose next candidate takes its place
    bool is_final = false;      // the cost is

    bool operator<(const Candidate& other) const {  // the standard heap has its largest element on top
      if (cost != other.cost) return cost > other.cost;
      return lower != other.lower ? lower > other.lower : higher > other.higher;
    }
  };

  void add_link(Index link, Index from, Index to) {
    links_[link] = {to, lists_[from].first};
    lists_[from].first = link;
    if (lists_[from].last == k_no_index) lists_[from].last = link;
  }

  /// What a cluster can be merged with.
  struct Offer {
    double cost;
    Index other;
    Index growth;  // of the other when the cost was computed

    // Those with the lower name first, where costs are equal; as pairs in the queue.
    bool operator<(const Offer& than) const {
      return cost != than.cost ? cost > than.cost : other > than.other;
    }
  };
  struct Offers {
    std::vector<Offer> list;  // the cheapest last
    Index growth = 0;         // of the cluster when they were made
  };

  /// Fills `neighbours_` and cleans the cluster's list.
  void find_neighbours(Index cluster) {
    seen_[cluster] = cluster;
    neighbours_.clear();
    links_to_.clear();
    for (Index place = lists_[cluster].first; place != k_no_index; place = links_[place].next) {
      const Index other = sets_.find(links_[place].item);
      if (seen_[other] == cluster) continue;
      seen_[other] = cluster;
      links_[place].item = other;
      neighbours_.push_back(other);
      links_to_.push_back(place);
    }
    seen_[cluster] = k_no_index;
    for (const Index other : neighbours_) seen_[other] = k_no_index;
    if constexpr (HasDistance<Policy>) {
      if (neighbours_.size() > options_.most_neighbours) keep_nearest(cluster);
    }
    Index* place = &lists_[cluster].first;
    lists_[cluster].last = k_no_index;
    for (const Index link : links_to_) {
      *place = link;
      lists_[cluster].last = link;
      place = &links_[link].next;
    }
    *place = k_no_index;
  }

  void keep_nearest(Index cluster) {
    distances_.clear();
    for (std::size_t i = 0; i < neighbours_.size(); ++i)
      distances_.emplace_back(policy_.distance(cluster, neighbours_[i]), static_cast<Index>(i));
    const auto end = distances_.begin() + static_cast<std::ptrdiff_t>(options_.most_neighbours);
    std::nth_element(distances_.begin(), end, distances_.end(), [&](const auto& a, const auto& b) {
      return a.first != b.first ? a.first < b.first : neighbours_[a.second] < neighbours_[b.second];
    });
    std::sort(distances_.begin(), end, [](const auto& a, const auto& b) { return a.second < b.second; });
    for (std::size_t i = 0; i < options_.most_neighbours; ++i) {
      neighbours_[i] = neighbours_[distances_[i].second];
      links_to_[i] = links_to_[distances_[i].second];
    }
    neighbours_.resize(options_.most_neighbours);
    links_to_.resize(options_.most_neighbours);
  }

  /// At the start each pair is offered once, by its lower item.
  void offer_all(Progress* progress) {
    constexpr std::size_t k_pairs_at_once = 1 << 16;
    for (Index first = 0, item = 0; item < result_.n_items; first = item) {
      report_progress(progress, "costs of pairs",
                      static_cast<double>(item) / static_cast<double>(result_.n_items));
      pairs_.clear();
      for (; item < result_.n_items && pairs_.size() < k_pairs_at_once; ++item) {
        find_neighbours(item);
        for (const Index other : neighbours_) {
          if (other > item) pairs_.emplace_back(item, other);
        }
      }
      compute_costs();
      std::size_t pair = 0;
      for (Index cluster = first; cluster < item; ++cluster) {
        const std::size_t begin = pair;
        while (pair < pairs_.size() && pairs_[pair].first == cluster) ++pair;
        offer(cluster, begin, pair);
      }
    }
  }

  void offer_neighbours(Index cluster) {
    find_neighbours(cluster);
    pairs_.clear();
    for (const Index other : neighbours_) pairs_.push_back(std::minmax(cluster, other));
    compute_costs();
    offer(cluster, 0, pairs_.size());
  }

  void compute_costs() {
    costs_.resize(pairs_.size());
    if constexpr (HasCostsOfPairs<Policy>) {
      policy_.costs(pairs_, costs_);
    } else {
      for (std::size_t i = 0; i < pairs_.size(); ++i)
        costs_[i] = policy_.cost(pairs_[i].first, pairs_[i].second);
    }
  }

  void offer(Index cluster, std::size_t begin, std::size_t end) {
    Offers& offers = offers_[cluster];
    offers.list.clear();
    offers.growth = growth_[cluster];
    for (std::size_t i = begin; i < end; ++i) {
      if (!(costs_[i] < std::numeric_limits<double>::infinity())) continue;
      const Index other = pairs_[i].first == cluster ? pairs_[i].second : pairs_[i].first;
      offers.list.push_back({costs_[i], other, growth_[other]});
    }
    std::sort(offers.list.begin(), offers.list.end());
    queue_next_of(cluster);
  }

  void queue_next_of(Index cluster) {
    std::vector<Offer>& list = offers_[cluster].list;
    while (!list.empty() && growth_[list.back().other] != list.back().growth) list.pop_back();
    if (list.empty()) return;
    const Offer& best = list.back();
    const auto [lower, higher] = std::minmax(cluster, best.other);
    push({best.cost, lower, higher, growth_[lower] + growth_[higher], cluster});
    list.pop_back();
  }

  bool is_void(const Candidate& candidate) const {
    return growth_[candidate.lower] + growth_[candidate.higher] != candidate.growth;
  }

  void push(const Candidate& candidate) {
    if (!(candidate.cost < std::numeric_limits<double>::infinity())) return;
    queue_.push_back(candidate);
    std::push_heap(queue_.begin(), queue_.end());
  }

  double final_cost(Index lower, Index higher) {
    if constexpr (HasFinalCost<Policy>) {
      return policy_.final_cost(lower, higher);
    } else {
      return policy_.cost(lower, higher);
    }
  }

  bool pop_cheapest(Candidate& cheapest) {
    while (!queue_.empty()) {
      std::pop_heap(queue_.begin(), queue_.end());
      cheapest = queue_.back();
      queue_.pop_back();
      const Index source = std::exchange(cheapest.source, k_no_index);
      if (source != k_no_index && offers_[source].growth == growth_[source]) queue_next_of(source);
      if (is_void(cheapest)) continue;
      if (HasLastingCosts<Policy> && (cheapest.is_final || !HasFinalCost<Policy>)) return true;
      const double cost = final_cost(cheapest.lower, cheapest.higher);
      if (cost <= cheapest.cost) return true;
      cheapest.cost = cost;  // it rose meanwhile
      cheapest.is_final = true;
      push(cheapest);
    }
    return false;
  }

  void merge(const Candidate& pair) {
    policy_.merge(pair.lower, pair.higher);
    sets_.merge(pair.lower, pair.higher);
    List& list = lists_[pair.lower];
    if (list.first == k_no_index) {
      list = lists_[pair.higher];
    } else {
      links_[list.last].next = lists_[pair.higher].first;
    }
    ++growth_[pair.lower];
    ++growth_[pair.higher];  // its entries are void
    result_.merges.push_back({pair.lower, pair.higher, pair.cost});
    offers_[pair.higher] = {};
    offer_neighbours(pair.lower);
  }

  Policy& policy_;
  const AgglomerationOptions& options_;
  Agglomeration result_;
  DisjointSets sets_;
  std::vector<List> lists_;
  std::vector<Index> growth_;  // merges that made each cluster
  std::vector<Index> seen_;
  std::vector<Offers> offers_;
  std::vector<Link> links_;
  std::vector<Index> neighbours_, links_to_;
  std::vector<std::pair<double, Index>> distances_;
  std::vector<std::pair<Index, Index>> pairs_;
  std::vector<double> costs_;
  std::vector<Candidate> queue_;
};

}  // namespace detail

/// Merges the cheapest pair of neighbouring clusters, starting from one cluster per item, until an option
/// stops it or no merge is left. Of pairs that cost the same the one with the lower names goes first, so the
/// same input gives the same tree. `neighbours` holds pairs of items, each once or more often, in either
/// order; clusters are neighbours when items of theirs are. A pair's cost is computed when one of the two has
/// grown, and again before it is merged unless it lasts. Throws `Cancelled`.
template <MergePolicy Policy>
Agglomeration agglomerate(std::size_t n_items, std::span<const std::pair<Index, Index>> neighbours,
                          Policy& policy, const AgglomerationOptions& options = {},
                          Progress* progress = nullptr) {
  return detail::Agglomerator<Policy>(n_items, neighbours, policy, options).run(progress);
}

}  // namespace recede
