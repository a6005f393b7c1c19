#include "nurbs_surfaces.h"
#include <recede/lod/detail/triangle_deviation.h>

#include <gtest/gtest.h>

namespace recede::detail {
namespace {

using test::RandomNurbs;

// The largest distance of points of equal parameters, at the points that divide all sides by `n`.
double sampled_deviation(const PatchSurface& surface, const std::array<Vec2, 3>& uvs, int n) {
  std::array<Vec3, 3> corners;
  for (std::size_t k = 0; k < 3; ++k) corners[k] = surface.shape.evaluate(uvs[k]);
  double largest = 0;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; i + j <= n; ++j) {
      const double a = static_cast<double>(i) / n, b = static_cast<double>(j) / n, c = 1 - a - b;
      const Vec3 on_surface = surface.shape.evaluate(a * uvs[0] + b * uvs[1] + c * uvs[2]);
      const Vec3 on_triangle = a * corners[0] + b * corners[1] + c * corners[2];
      largest = std::max(largest, (on_surface - on_triangle).norm());
    }
  }
  return largest;
}

std::array<Vec2, 3> random_triangle(RandomNurbs& random, const ParameterBox& domain, double size) {
  const Vec2 sizes = size * domain.sizes();
  const Vec2 corner =
      domain.min() + Vec2(random.number(0, 1), random.number(0, 1)).cwiseProduct(domain.sizes() - sizes);
  std::array<Vec2, 3> uvs;
  for (Vec2& uv : uvs) uv = corner + Vec2(random.number(0, 1), random.number(0, 1)).cwiseProduct(sizes);
  return uvs;
}

// z = x^2 over the unit square: a chord of width w is w^2 / 4 away at most.
TEST(TriangleDeviation, OfAParabolaIsAFourthOfTheSquaredWidth) {
  const PatchSurface surface(
      NurbsSurface{{2, 1},
                   {std::vector<double>{0, 0, 0, 1, 1, 1}, {0, 0, 1, 1}},
                   {{0, 0, 0}, {0, 1, 0}, {0.5, 0, 0}, {0.5, 1, 0}, {1, 0, 1}, {1, 1, 1}},
                   {}});
  for (const double width : {1.0, 0.5, 0.1}) {
    const std::array<Vec2, 3> uvs{Vec2(0, 0), Vec2(width, 0), Vec2(0, 1)};
    EXPECT_NEAR(sampled_deviation(surface, uvs, 32), width * width / 4, 1e-12);
    EXPECT_NEAR(measured_deviation(surface, uvs), width * width / 4, 1e-12);
    const double bound = triangle_deviation(surface, uvs, 1e-9);
    EXPECT_GE(bound, width * width / 4);
    // Smaller triangles of a third level would add a 64th; the bound is for one with a right angle.
    EXPECT_LE(bound, 1.1 * width * width / 4);
  }
}

TEST(TriangleDeviation, OfAPlaneIsNothing) {
  const PatchSurface surface(NurbsSurface{{1, 1},
                                          {std::vector<double>{0, 0, 1, 1}, {0, 0, 1, 1}},
                                          {{5, 5, 1}, {5, 7, 1}, {8, 5, 1}, {8, 7, 1}},
                                          {}});
  EXPECT_EQ(triangle_deviation(surface, {Vec2(0, 0), Vec2(1, 0), Vec2(0.3, 1)}, 0), 0);
}

TEST(TriangleDeviation, HoldsAtDenseSamplesOfRandomSurfaces) {
  RandomNurbs random(5);
  for (int round = 0; round < 40; ++round) {
    const int degree = random.integer(1, 4);
    const PatchSurface surface(random.sheet(degree, random.integer(1, 4), random.integer(0, 6),
                                            round % 2 == 0, round % 4 == 0 ? degree : 1));
    for (int i = 0; i < 20; ++i) {
      const std::array<Vec2, 3> uvs =
          random_triangle(random, surface.shape.domain(), std::exp2(random.number(-8, 0)));
      const double met = sampled_deviation(surface, uvs, 24);
      // 1e-13: rounding of the evaluation itself, of surfaces about ten wide.
      EXPECT_LE(measured_deviation(surface, uvs), met + 1e-13);
      for (const double share : {0.0, 0.3, 0.9, 1.1, 2.0, 1e9}) {
        const double bound = triangle_deviation(surface, uvs, share * met);
        EXPECT_GE(bound, met - 1e-13) << "round " << round << ", enough: " << share;
      }
    }
  }
}

// What is far above the largest deviation is accepted at the latest when it is twice it: the third level is
// 64 times narrower than bounds that are within about thirty times of what is there.
TEST(TriangleDeviation, IsWithinTwiceTheLargestWhereThatIsAsked) {
  RandomNurbs random(6);
  int n = 0, n_good = 0;
  for (int round = 0; round < 40; ++round) {
    const PatchSurface surface(
        random.sheet(random.integer(2, 4), random.integer(2, 4), random.integer(0, 4), round % 2 == 0, 1));
    for (int i = 0; i < 10; ++i) {
      const std::array<Vec2, 3> uvs =
          random_triangle(random, surface.shape.domain(), std::exp2(random.number(-6, -2)));
      const double met = sampled_deviation(surface, uvs, 24);
      if (met < 1e-9) continue;
      ++n;
      n_good += triangle_deviation(surface, uvs, 1.5 * met) <= 1.5 * met ? 1 : 0;
    }
  }
  ASSERT_GT(n, 300);
  // Slivers, over whose boxes derivatives are larger than along them, are the rest.
  EXPECT_GT(n_good, 0.9 * n);
}

TEST(TriangleDeviation, SaysMoreThanEnoughWhenItIsMore) {
  RandomNurbs random(7);
  for (int round = 0; round < 100; ++round) {
    const PatchSurface surface(random.sheet(3, 3, 2, false, 1));
    const std::array<Vec2, 3> uvs = random_triangle(random, surface.shape.domain(), 0.5);
    const double met = sampled_deviation(surface, uvs, 24);
    EXPECT_GT(triangle_deviation(surface, uvs, 0.9 * met), 0.9 * met);
  }
}

TEST(TriangleDeviation, OfBallsHoldsAtPoles) {
  const PatchSurface surface(test::ball(1));
  RandomNurbs random(8);
  for (int round = 0; round < 100; ++round) {
    const double u = random.number(0, 3), width = random.number(0.01, 1), height = random.number(0.01, 0.5);
    const std::array<Vec2, 3> uvs{Vec2(u, 0), Vec2(u + width, height), Vec2(u, height)};
    const double met = sampled_deviation(surface, uvs, 24);
    EXPECT_GE(triangle_deviation(surface, uvs, 1.2 * met), met - 1e-14);
  }
}

}  // namespace
}  // namespace recede::detail
