#include <recede/geometry/closest_point.h>
#include <recede/geometry/sample_models.h>

#include <gtest/gtest.h>

#include <algorithm>
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

TEST(ClosestPoint, TrianglesWithinADistanceAreThoseOfBruteForce) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> unit(0, 1);
  std::size_t found = 0;
  for (const std::size_t n : {1u, 3u, 5u, 40u, 300u}) {
    const Triangles triangles = random_triangles(n, random);
    const ClosestPointTree tree(triangles.positions, triangles.corners);
    for (int query = 0; query < 100; ++query) {
      const Vec3 p(unit(random), unit(random), unit(random));
      const double distance = unit(random) * unit(random);
      std::vector<Index> expected, hits;
      for (Index t = 0; t < n; ++t) {
        if ((closest_point_on_triangle(p, tree.triangle(t)) - p).squaredNorm() <= distance * distance)
          expected.push_back(t);
      }
      for (const ClosestPointTree::Hit& hit : tree.closest_within(p, distance)) {
        hits.push_back(hit.triangle);
        EXPECT_EQ(hit.point, closest_point_on_triangle(p, tree.triangle(hit.triangle)));
        EXPECT_EQ(hit.squared_distance, (hit.point - p).squaredNorm());
      }
      std::sort(hits.begin(), hits.end());
      EXPECT_EQ(hits, expected);
      found += hits.size();
    }
  }
  EXPECT_GT(found, 200u);
}

/// By Cramer's rule, in the order of the list.
double nearest_crossing_by_brute_force(const Triangles& triangles, const Vec3& origin, const Vec3& direction,
                                       double limit) {
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t + 2 < triangles.corners.size(); t += 3) {
    const Vec3 a = triangles.positions[triangles.corners[t]];
    const Vec3 ab = triangles.positions[triangles.corners[t + 1]] - a;
    const Vec3 ac = triangles.positions[triangles.corners[t + 2]] - a;
    if (ab.cross(ac).dot(direction) <= 0) continue;
    Eigen::Matrix3d columns;
    columns << ab, ac, -direction;
    const Vec3 solution = columns.inverse() * (origin - a);
    if (solution.x() < 0 || solution.y() < 0 || solution.x() + solution.y() > 1) continue;
    if (std::abs(solution.z()) <= limit && std::abs(solution.z()) < std::abs(best)) best = solution.z();
  }
  return best;
}

TEST(ClosestPoint, TheNearestCrossingOfALineIsThatOfBruteForce) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  std::size_t found = 0;
  for (const std::size_t n : {1u, 3u, 5u, 40u, 300u}) {
    const Triangles triangles = random_triangles(n, random);
    const ClosestPointTree tree(triangles.positions, triangles.corners);
    for (int query = 0; query < 3000; ++query) {
      const Vec3 origin(unit(random), unit(random), unit(random));
      Vec3 direction = Vec3(unit(random), unit(random), unit(random)) - Vec3::Constant(0.5);
      if (query % 3 == 0) direction = (query % 2 == 0 ? 1 : -1) * Vec3::Unit(query % 9 / 3);
      const double limit = query % 2 == 0 ? 0.3 : 10;
      const double expected = nearest_crossing_by_brute_force(triangles, origin, direction, limit);
      const auto hit = tree.nearest_crossing(origin, direction, limit);
      ASSERT_EQ(hit.triangle == k_no_index, std::isinf(expected));
      if (hit.triangle == k_no_index) continue;
      ++found;
      EXPECT_NEAR(hit.distance, expected, 1e-9);
      const Triangle t = tree.triangle(hit.triangle);
      const Vec3 point = hit.weights[0] * t.a + hit.weights[1] * t.b + hit.weights[2] * t.c;
      EXPECT_LT((point - (origin + hit.distance * direction)).norm(), 1e-9);
    }
  }
  EXPECT_GT(found, 200u);
}

TEST(ClosestPoint, NoLineSlipsThroughAtEdgesAndCornersOfAClosedSurface) {
  const PolygonSoup soup = make_displaced_sphere(500, true);
  const std::vector<Index> corners = triangulate(soup);
  const ClosestPointTree tree(soup.positions, corners);
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int query = 0; query < 20000; ++query) {
    const std::size_t t = 3 * (random() % (corners.size() / 3)), k = random() % 3;
    const Vec3 a = soup.positions[corners[t + k]], b = soup.positions[corners[t + (k + 1) % 3]];
    const double share = query % 4 == 0 ? 0 : unit(random);
    const Vec3 origin(0.01 * unit(random), 0, 0);
    const Vec3 direction = a + share * (b - a) - origin;
    const auto hit = tree.nearest_crossing(origin, direction, 2);
    ASSERT_NE(hit.triangle, k_no_index) << "query " << query;
    EXPECT_NEAR(hit.distance, 1, 1e-9);
  }
}

TEST(ClosestPoint, ALineAlongAnAxisMeetsTheBorderOnEverySide) {
  // A strip of six squares: more triangles than a leaf holds, so that boxes are tested.
  std::vector<Vec3> positions;
  std::vector<Index> corners;
  for (Index i = 0; i <= 6; ++i) {
    for (const double y : {0.0, 1.0}) positions.emplace_back(i, y, 0);
    if (i == 6) break;
    for (const Index k : {0u, 2u, 3u, 0u, 3u, 1u}) corners.push_back(2 * i + k);
  }
  const ClosestPointTree tree(positions, corners);
  for (const Vec3& border : {Vec3(0, .5, 0), Vec3(6, .5, 0), Vec3(2.5, 0, 0), Vec3(2.5, 1, 0)}) {
    EXPECT_EQ(tree.nearest_crossing(border - Vec3::UnitZ(), Vec3::UnitZ(), 3).distance, 1) << border;
  }
}

TEST(ClosestPoint, ALineMissesTrianglesThatFaceAgainstItAndThoseBeyondTheLimit) {
  const std::vector<Vec3> square = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const ClosestPointTree tree(square, {0, 1, 2, 0, 2, 3});
  const Vec3 above(0.25, 0.5, 2);
  EXPECT_EQ(tree.nearest_crossing(above, Vec3::UnitZ(), 3).distance, -2) << "behind the origin";
  EXPECT_EQ(tree.nearest_crossing(above, Vec3::UnitZ(), 2).distance, -2) << "just at the limit";
  EXPECT_EQ(tree.nearest_crossing(above, Vec3::UnitZ(), 1.9).triangle, k_no_index);
  EXPECT_EQ(tree.nearest_crossing(above, -Vec3::UnitZ(), 3).triangle, k_no_index);
  EXPECT_EQ(tree.nearest_crossing(above, Vec3::Zero(), 3).triangle, k_no_index);
}

}  // namespace
}  // namespace recede
