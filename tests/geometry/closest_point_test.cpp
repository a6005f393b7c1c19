#include <recede/geometry/closest_point.h>

#include <gtest/gtest.h>

#include <random>

namespace recede {
namespace {

struct Triangles {
  std::vector<Vec3> positions;
  std::vector<Index> corners;
};

Triangles random_triangles(std::size_t n, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  Triangles result;
  for (std::size_t t = 0; t < n; ++t) {
    const Vec3 at(unit(random), unit(random), unit(random));
    for (int k = 0; k < 3; ++k) {
      result.corners.push_back(static_cast<Index>(result.positions.size()));
      result.positions.push_back(at + 0.1 * Vec3(unit(random), unit(random), unit(random)));
    }
  }
  return result;
}

TEST(ClosestPoint, OfOtherLabelsIsThatOfBruteForce) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const std::size_t n : {1u, 3u, 5u, 40u, 300u}) {
    const Triangles triangles = random_triangles(n, random);
    ClosestPointTree tree(triangles.positions, triangles.corners);
    std::vector<Index> labels(n);
    for (Index& label : labels) label = static_cast<Index>(random() % 4);
    tree.set_labels(labels);
    for (int query = 0; query < 200; ++query) {
      const Vec3 p(unit(random), unit(random), unit(random));
      const auto own = static_cast<Index>(random() % 4);
      const double limit = query % 2 == 0 ? 0.01 : std::numeric_limits<double>::infinity();
      double expected = limit;
      for (Index t = 0; t < n; ++t) {
        if (labels[t] == own) continue;
        expected = std::min(expected, (closest_point_on_triangle(p, tree.triangle(t)) - p).squaredNorm());
      }
      const auto hit = tree.closest_of_others(p, own, limit);
      EXPECT_EQ(hit.squared_distance, expected);
      EXPECT_EQ(hit.triangle == k_no_index, expected == limit);
      if (hit.triangle != k_no_index) {
        EXPECT_NE(labels[hit.triangle], own);
      }
    }
  }
}

}  // namespace
}  // namespace recede
