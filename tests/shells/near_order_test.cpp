// The order in which many points are answered.
#include <recede/shells/detail/near_order.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

namespace recede {
namespace {

std::vector<std::uint32_t> sorted(std::vector<std::uint32_t> order) {
  std::sort(order.begin(), order.end());
  return order;
}

std::vector<std::uint32_t> numbers(std::size_t n) {
  std::vector<std::uint32_t> all(n);
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

TEST(NearOrder, GoesThroughAGridFromNeighbourToNeighbour) {
  // 16^3 points in the middles of equal cubes of cells, shuffled: along Hilbert's curve each is one step from
  // the last.
  std::vector<Vec3> points;
  for (int x = 0; x < 16; ++x) {
    for (int y = 0; y < 16; ++y) {
      for (int z = 0; z < 16; ++z) points.emplace_back(x, y, z);
    }
  }
  std::mt19937 random(3);
  std::shuffle(points.begin(), points.end(), random);
  const std::vector<std::uint32_t> order = detail::near_order(points);
  EXPECT_EQ(sorted(order), numbers(points.size()));
  for (std::size_t i = 1; i < order.size(); ++i)
    EXPECT_EQ((points[order[i]] - points[order[i - 1]]).lpNorm<1>(), 1) << i;
}

TEST(NearOrder, TakesWhateverPointsThereAre) {
  constexpr double k_infinity = std::numeric_limits<double>::infinity();
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(detail::near_order({}).empty());
  const std::vector<Vec3> same(5, Vec3(1, 2, 3));
  EXPECT_EQ(detail::near_order(same), numbers(5)) << "as they came";
  const std::vector<Vec3> wild = {Vec3(nothing, 0, 0),
                                  Vec3(0, k_infinity, 0),
                                  Vec3(0, 0, -k_infinity),
                                  Vec3::Constant(1.7e308),
                                  Vec3::Constant(-1.7e308),
                                  Vec3::Constant(5e-324),
                                  Vec3(nothing, nothing, nothing),
                                  Vec3::Zero()};
  EXPECT_EQ(sorted(detail::near_order(wild)), numbers(wild.size()));
}

}  // namespace
}  // namespace recede
