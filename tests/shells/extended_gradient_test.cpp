#include "lp_shapes.h"
#include <recede/geometry/error.h>

#include <gtest/gtest.h>

#include <random>

namespace recede {
namespace {

using namespace test;

ClosestPointTree tree_of(const PolygonSoup& soup) { return {soup.positions, triangulate(soup)}; }

/// The unit cube from inside and outside.
PolygonSoup cube() {
  PolygonSoup soup;
  for (int k = 0; k < 3; ++k) {
    const Vec3 u = Vec3::Unit((k + 1) % 3), v = Vec3::Unit((k + 2) % 3);
    add_sheet(soup, Vec3::Zero(), u, v);
    add_sheet(soup, Vec3::Unit(k), u, v);
  }
  return soup;
}

TEST(ExtendedGradient, OverOneFaceIsTheNormal) {
  const ClosestPointTree box = tree_of(cube());
  EXPECT_LT((extended_gradient(box, Vec3(0.3, 0.4, 0.1)) - Vec3::UnitZ()).norm(), 1e-12);
  EXPECT_LT((extended_gradient(box, Vec3(0.3, 0.4, -7)) + Vec3::UnitZ()).norm(), 1e-12);
  const Vec3 beyond_corner = Vec3(2, 3, 1.5) - Vec3::Ones();
  EXPECT_LT((extended_gradient(box, Vec3(2, 3, 1.5)) - beyond_corner.normalized()).norm(), 1e-12);
}

TEST(ExtendedGradient, BetweenTwoPlanesIsTheCosineOfHalfTheAngleOfTheirNormals) {
  for (const double degrees : {30.0, 60.0, 90.0, 150.0}) {
    const double angle = degrees * k_pi / 180;
    const Vec3 g = extended_gradient(tree_of(dihedral(angle, 10)), Vec3(1, 0, 0.3));
    // Normals are as far apart as the planes' angle is less than a straight one.
    EXPECT_LT((g - std::sin(0.5 * angle) * Vec3::UnitX()).norm(), 1e-9) << degrees;
  }
  const ClosestPointTree box = tree_of(cube());
  EXPECT_LT((extended_gradient(box, Vec3(0.2, 0.2, 0.5)) - Vec3(0.5, 0.5, 0)).norm(), 1e-9);
}

TEST(ExtendedGradient, InABoxIsThatOfTheCornerOnItsDiagonalAndNothingInTheMiddle) {
  const ClosestPointTree box = tree_of(cube());
  EXPECT_LT((extended_gradient(box, Vec3::Constant(0.1)) - Vec3::Ones() / 3).norm(), 1e-9);
  EXPECT_NEAR(extended_gradient(box, Vec3::Constant(0.3)).norm(), 1 / std::sqrt(3.0), 1e-9);
  EXPECT_LT(extended_gradient(box, Vec3::Constant(0.5)).norm(), 1e-9);
  EXPECT_EQ(extended_gradient(box, Vec3(0.5, 0.5, 0)), Vec3::Zero()) << "on the surface";
  EXPECT_LT(extended_gradient(tree_of(sphere(4)), Vec3::Zero(), {.tolerance = 0.02}).norm(), 1e-9)
      << "thousands of nearest points";
}

TEST(ExtendedGradient, DoesNotDependOnScaleOrPlace) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vec3(1, -2, 2).normalized()).toRotationMatrix();
  for (const double scale : {1e-9, 1.0, 1e9}) {
    const Vec3 by = scale * Vec3(100, -50, 30);
    const ClosestPointTree box = tree_of(moved(cube(), scale, turn, by));
    const Vec3 g = extended_gradient(box, scale * (turn * Vec3::Constant(0.2)) + by);
    // Places are rounded by 1e-14 of the box's size.
    EXPECT_LT((g - turn * Vec3::Ones() / 3).norm(), 1e-10) << scale;
  }
}

TEST(ExtendedGradient, IsTheGreatestGrowthOfTheDistance) {
  // Of the distance to points on a sphere around x, by trying directions.
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto direction = [&] { return Vec3(normal(random), normal(random), normal(random)).normalized(); };
  for (int i = 0; i < 30; ++i) {
    PolygonSoup specks;
    std::vector<Vec3> points;
    for (int k = 0; k < 2 + i % 6; ++k) {
      points.push_back(direction());
      if (i % 2 == 0) points.back() = Vec3(points.back() + 1.5 * Vec3::UnitX()).normalized();
      specks.positions.insert(specks.positions.end(), 3, points.back());
      specks.add_face(std::array<Index, 3>{Index(3 * k), Index(3 * k + 1), Index(3 * k + 2)});
    }
    const Vec3 g = extended_gradient(tree_of(specks), Vec3::Zero());
    // Along u the distance grows by the least of -u.p; the greatest over u is the length of g.
    const auto growth = [&](const Vec3& u) {
      double least = 1;
      for (const Vec3& p : points) least = std::min(least, -u.dot(p));
      return least;
    };
    if (g.norm() > 1e-6) {
      EXPECT_NEAR(growth(g.normalized()), g.norm(), 1e-9);
    }
    for (int k = 0; k < 2000; ++k) EXPECT_LT(growth(direction()), g.norm() + 1e-9);
  }
}

TEST(ExtendedGradient, RefusesANegativeTolerance) {
  EXPECT_THROW(extended_gradient(tree_of(cube()), Vec3::Zero(), {.tolerance = -1}), OptionError);
}

}  // namespace
}  // namespace recede
