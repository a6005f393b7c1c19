#include <recede/lod/detail/polygon_normal.h>

#include <gtest/gtest.h>

#include <numbers>
#include <random>
#include <vector>

namespace recede::detail {
namespace {

Vec3 random_point(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  return {unit(random), unit(random), unit(random)};
}

// Claim 3.
TEST(PolygonNormal, OfATriangleIsItsCrossProduct) {
  std::mt19937 random(3);
  for (int i = 0; i < 100; ++i) {
    const std::vector<Vec3> t{random_point(random), random_point(random), random_point(random)};
    const Vec3 cross = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
    EXPECT_LT((corner_average_normal(t) - cross).norm(), 1e-12);
    // The corner average of a triangle by the general formula is the same vector.
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k) sum += (t[(k + 1) % 3] - t[k]).cross(t[(k + 2) % 3] - t[k]);
    EXPECT_LT((sum.normalized() - cross).norm(), 1e-12);
  }
}

TEST(PolygonNormal, OfAQuadIsTheCrossProductOfItsDiagonals) {
  std::mt19937 random(4);
  for (int i = 0; i < 100; ++i) {
    const std::vector<Vec3> q{random_point(random), random_point(random), random_point(random),
                              random_point(random)};
    EXPECT_LT((corner_average_normal(q) - (q[2] - q[0]).cross(q[3] - q[1]).normalized()).norm(), 1e-12);
  }
}

TEST(PolygonNormal, OfAFlatConvexPolygonIsUprightCounterClockwise) {
  for (int n = 3; n <= 12; ++n) {
    std::vector<Vec3> polygon;
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * i / n;
      polygon.emplace_back(5e3 + 2 * std::cos(angle), std::sin(angle), 7);
    }
    EXPECT_LT((corner_average_normal(polygon) - Vec3::UnitZ()).norm(), 1e-9);
    EXPECT_LT((vector_area_normal(polygon) - Vec3::UnitZ()).norm(), 1e-9);
  }
}

// The caveat of the source's formula: for concave polygons the corner average may point the wrong way, the
// vector area never does.
TEST(PolygonNormal, OfAStarIsRightByVectorAreaAndSometimesWrongByCornerAverage) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> radius(0.05, 1);
  int wrong = 0;
  for (int i = 0; i < 2000; ++i) {
    const int n = 5 + i % 8;
    std::vector<Vec3> star;
    for (int k = 0; k < n; ++k) {
      const double angle = 2 * std::numbers::pi * k / n, r = radius(random);
      star.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
    }
    EXPECT_GT(vector_area_normal(star).z(), 0.999);
    if (corner_average_normal(star).z() < 0) ++wrong;
  }
  EXPECT_GT(wrong, 0);
  EXPECT_LT(wrong, 400);
}

TEST(PolygonNormal, OfAPolygonWithoutAreaIsZero) {
  EXPECT_TRUE(corner_average_normal(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}).isZero(0));
  EXPECT_TRUE(corner_average_normal(std::vector<Vec3>{{0, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 0, 0}})
                  .isZero(0));
}

}  // namespace
}  // namespace recede::detail
