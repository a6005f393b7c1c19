#include <recede/geometry/agglomerate.h>
#include <recede/geometry/error.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

namespace recede {
namespace {

using ::testing::ElementsAre;
using Neighbours = std::vector<std::pair<Index, Index>>;
constexpr double k_refused = std::numeric_limits<double>::infinity();

/// Intervals on a line: merging costs the length of the union, and more than `longest` is refused.
struct Intervals {
  std::vector<double> lower, upper;
  double longest = k_refused;

  explicit Intervals(const std::vector<double>& points) : lower(points), upper(points) {}
  double cost(Index a, Index b) const {
    const double length = std::max(upper[a], upper[b]) - std::min(lower[a], lower[b]);
    return length > longest ? k_refused : length;
  }
  void merge(Index a, Index b) {
    lower[a] = std::min(lower[a], lower[b]);
    upper[a] = std::max(upper[a], upper[b]);
  }
};

const Neighbours k_chain = {{0, 1}, {1, 2}, {2, 3}};

std::vector<std::pair<Index, Index>> pairs(const Agglomeration& tree) {
  std::vector<std::pair<Index, Index>> result;
  for (const ClusterMerge& merge : tree.merges) result.emplace_back(merge.kept, merge.absorbed);
  return result;
}

TEST(Agglomerate, MergesTheCheapestPairFirstAndRecordsTheTree) {
  Intervals points({0, 10, 11, 13});
  const Agglomeration tree = agglomerate(4, k_chain, points);
  EXPECT_THAT(pairs(tree), ElementsAre(std::pair(1, 2), std::pair(1, 3), std::pair(0, 1)));
  EXPECT_EQ(tree.merges[0].cost, 1);
  EXPECT_EQ(tree.merges[1].cost, 3);
  EXPECT_EQ(tree.merges[2].cost, 13);
  EXPECT_EQ(tree.reason, AgglomerationStop::cluster_target);
  EXPECT_THAT(clusters_after(tree, 0), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(clusters_after(tree, 1), ElementsAre(0, 1, 1, 2));
  EXPECT_THAT(clusters_after(tree, 2), ElementsAre(0, 1, 1, 1));
  EXPECT_THAT(clusters_after(tree, 3), ElementsAre(0, 0, 0, 0));
}

TEST(Agglomerate, StopsAtTheNumberOfClustersTheCostLimitOrWhenAllIsRefused) {
  Intervals points({0, 10, 11, 13});
  EXPECT_EQ(agglomerate(4, k_chain, points, {.clusters = 3}).n_clusters(), 3u);
  points = Intervals({0, 10, 11, 13});
  const Agglomeration limited = agglomerate(4, k_chain, points, {.cost_limit = 3});
  EXPECT_EQ(limited.n_clusters(), 2u);
  EXPECT_EQ(limited.reason, AgglomerationStop::cost_limit);
  points = Intervals({0, 10, 11, 13});
  points.longest = 2;
  const Agglomeration refused = agglomerate(4, k_chain, points);
  EXPECT_EQ(refused.n_clusters(), 3u);
  EXPECT_EQ(refused.reason, AgglomerationStop::no_merge_left);
}

TEST(Agglomerate, TiesGoToTheLowerNamesWhateverTheOrderOfTheNeighbours) {
  Intervals a({0, 1, 2, 3}), b = a;
  const Neighbours reversed = {{3, 2}, {2, 1}, {1, 2}, {1, 0}, {2, 3}};
  const Agglomeration tree = agglomerate(4, k_chain, a);
  EXPECT_THAT(pairs(tree), ElementsAre(std::pair(0, 1), std::pair(2, 3), std::pair(0, 2)));
  EXPECT_EQ(pairs(tree), pairs(agglomerate(4, reversed, b)));
}

TEST(Agglomerate, NothingToMergeIsNoError) {
  Intervals none({});
  EXPECT_EQ(agglomerate(0, {}, none).n_clusters(), 0u);
  Intervals two({0, 1});
  EXPECT_EQ(agglomerate(2, {}, two).n_clusters(), 2u);
}

TEST(Agglomerate, StopsWhenAsked) {
  struct Impatient : Progress {
    void update(std::string_view, double) override {}
    bool cancel_requested() const override { return true; }
  } impatient;
  Intervals points({0, 1, 2, 3});
  EXPECT_THROW(agglomerate(4, k_chain, points, {}, &impatient), Cancelled);
}

/// Discs that grow; refuses pairs by a rule that depends on both.
struct Discs {
  std::vector<Vec2> middle;
  std::vector<double> weight;

  double cost(Index a, Index b) const {
    if (std::fmod(weight[a] * 7 + weight[b] * 3, 5.0) > 4.2) return k_refused;
    // Coarse steps, so that ties are common.
    return std::floor(8 * (middle[a] - middle[b]).norm()) * (weight[a] + weight[b]);
  }
  void merge(Index a, Index b) {
    middle[a] = (weight[a] * middle[a] + weight[b] * middle[b]) / (weight[a] + weight[b]);
    weight[a] += weight[b];
  }
};

/// Looks at every pair in every step.
std::vector<ClusterMerge> merge_naively(std::size_t n, const Neighbours& neighbours, Discs discs,
                                        const AgglomerationOptions& options) {
  std::vector<Index> cluster(n);
  for (Index i = 0; i < n; ++i) cluster[i] = i;
  std::vector<ClusterMerge> merges;
  // A pair keeps the cost of the time when one of the two grew last; costs depend on the two alone.
  while (n - merges.size() > options.clusters) {
    ClusterMerge best{0, 0, k_refused};
    for (const auto& [i, j] : neighbours) {
      const auto [a, b] = std::minmax(cluster[i], cluster[j]);
      if (a == b) continue;
      const double cost = discs.cost(a, b);
      if (std::tie(cost, a, b) < std::tie(best.cost, best.kept, best.absorbed)) best = {a, b, cost};
    }
    if (best.cost == k_refused || best.cost > options.cost_limit) break;
    discs.merge(best.kept, best.absorbed);
    std::replace(cluster.begin(), cluster.end(), best.absorbed, best.kept);
    merges.push_back(best);
  }
  return merges;
}

TEST(Agglomerate, GivesWhatLookingAtEveryPairGives) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const std::size_t n = 2 + random() % 150;
    Discs discs;
    for (std::size_t i = 0; i < n; ++i) {
      discs.middle.emplace_back(unit(random), unit(random));
      discs.weight.push_back(1);
    }
    Neighbours neighbours;
    for (std::size_t e = 0; e < 3 * n; ++e) {
      const auto a = static_cast<Index>(random() % n), b = static_cast<Index>(random() % n);
      if (a != b) neighbours.emplace_back(a, b);
    }
    AgglomerationOptions options;
    options.clusters = 1 + random() % 5;
    if (seed % 3 == 0) options.cost_limit = 20;
    const auto expected = merge_naively(n, neighbours, discs, options);
    const Agglomeration tree = agglomerate(n, neighbours, discs, options);
    ASSERT_EQ(tree.merges.size(), expected.size()) << "seed " << seed;
    for (std::size_t m = 0; m < expected.size(); ++m) {
      ASSERT_EQ(tree.merges[m].kept, expected[m].kept) << "seed " << seed << ", merge " << m;
      ASSERT_EQ(tree.merges[m].absorbed, expected[m].absorbed);
      ASSERT_EQ(tree.merges[m].cost, expected[m].cost);
    }
  }
}

/// The same, as a policy that says more of itself.
struct DiscsAtOnce : Discs {
  static constexpr bool k_costs_are_of_pairs_alone = true;

  void costs(std::span<const std::pair<Index, Index>> pairs, std::span<double> results) const {
    for (std::size_t i = 0; i < pairs.size(); ++i) results[i] = cost(pairs[i].first, pairs[i].second);
  }
  double distance(Index a, Index b) const { return (middle[a] - middle[b]).norm(); }
};

DiscsAtOnce random_discs(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  DiscsAtOnce discs;
  for (std::size_t i = 0; i < n; ++i) {
    discs.middle.emplace_back(unit(random), unit(random));
    discs.weight.push_back(1);
  }
  return discs;
}

Neighbours all_pairs(Index n) {
  Neighbours neighbours;
  for (Index a = 0; a < n; ++a) {
    for (Index b = a + 1; b < n; ++b) neighbours.emplace_back(a, b);
  }
  return neighbours;
}

TEST(Agglomerate, GivesTheSameForCostsOfManyPairsAtOnceAndForCostsThatLast) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    DiscsAtOnce at_once = random_discs(60, seed);
    Discs one_by_one = at_once;
    const Neighbours neighbours = all_pairs(60);
    EXPECT_EQ(pairs(agglomerate(60, neighbours, at_once)), pairs(agglomerate(60, neighbours, one_by_one)));
  }
}

TEST(Agglomerate, KeepsTheNearestNeighboursWhateverTheirOrder) {
  DiscsAtOnce a = random_discs(60, 3), b = a, c = a;
  Neighbours neighbours = all_pairs(60);
  const auto few = pairs(agglomerate(60, neighbours, a, {.most_neighbours = 3}));
  EXPECT_NE(few, pairs(agglomerate(60, neighbours, b)));
  std::shuffle(neighbours.begin(), neighbours.end(), std::mt19937(1));
  EXPECT_EQ(few, pairs(agglomerate(60, neighbours, c, {.most_neighbours = 3})));
}

/// A pair's cost that rises when clusters elsewhere merge: the number of merges so far.
struct Rising {
  std::vector<double> base;
  int merged = 0;

  double cost(Index a, Index) const { return base[a] + (a == 0 ? 10 * merged : 0); }
  void merge(Index, Index) { ++merged; }
};

TEST(Agglomerate, APairWhoseCostRoseMeanwhileWaitsForItsTurn) {
  Rising rising{{2, 0, 1, 0, 5, 0}};
  const Neighbours apart = {{0, 1}, {2, 3}, {4, 5}};
  const Agglomeration tree = agglomerate(6, apart, rising);
  EXPECT_THAT(pairs(tree), ElementsAre(std::pair(2, 3), std::pair(4, 5), std::pair(0, 1)));
  EXPECT_EQ(tree.merges.back().cost, 22);
}

}  // namespace
}  // namespace recede
