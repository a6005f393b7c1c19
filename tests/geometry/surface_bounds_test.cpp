#include "trimmed_patches.h"
#include <recede/geometry/patch_surface.h>

#include <gtest/gtest.h>

namespace recede {
namespace {

using test::RandomNurbs;

ParameterBox random_part(RandomNurbs& random, const ParameterBox& domain) {
  // Small parts as often as large ones.
  const double size = std::exp2(random.number(-8, 0));
  const Vec2 sizes = size * domain.sizes();
  const Vec2 corner =
      domain.min() + Vec2(random.number(0, 1), random.number(0, 1)).cwiseProduct(domain.sizes() - sizes);
  return {corner, corner + sizes};
}

Vec2 random_place(RandomNurbs& random, const ParameterBox& part) {
  return part.min() + Vec2(random.number(0, 1), random.number(0, 1)).cwiseProduct(part.sizes());
}

TEST(SurfaceBounds, HoldEverywhereOnRandomSurfaces) {
  RandomNurbs random(1);
  for (int round = 0; round < 60; ++round) {
    const NurbsSurface surface =
        random.sheet(random.integer(1, 4), random.integer(1, 4), random.integer(0, 5), round % 2 == 0, 1);
    const BezierPatches patches(surface);
    const SurfaceBounds bounds(patches);
    for (int i = 0; i < 20; ++i) {
      const ParameterBox part = random_part(random, patches.domain());
      const Box3 box = bounds.box(part);
      const DerivativeBounds most = bounds.derivatives(part);
      const NormalCone cone = bounds.normal_cone(part);
      const Vec3 eye(random.number(-9, 9), random.number(-9, 9), random.number(-9, 9));
      const double distance = bounds.distance(part, eye);
      for (int k = 0; k < 30; ++k) {
        const Vec2 uv = random_place(random, part);
        const SurfaceDerivatives here = patches.derivatives(uv);
        EXPECT_TRUE(box.contains(here.point));
        EXPECT_LE(distance, (here.point - eye).norm());
        EXPECT_LE(here.du.norm(), most.u);
        EXPECT_LE(here.dv.norm(), most.v);
        EXPECT_LE(here.duu.norm(), most.uu);
        EXPECT_LE(here.duv.norm(), most.uv);
        EXPECT_LE(here.dvv.norm(), most.vv);
        if (here.du.cross(here.dv).norm() > 1e-9) {
          EXPECT_LE(angle_between(cone.axis, here.du.cross(here.dv)), cone.angle);
        }
      }
    }
  }
}

// Kinks are there where a knot is as often as the degree.
TEST(SurfaceBounds, OfDeviationHoldForTrianglesEvenAcrossKinks) {
  RandomNurbs random(2);
  for (int round = 0; round < 60; ++round) {
    const int degree = random.integer(1, 4);
    const NurbsSurface surface = random.sheet(degree, degree, random.integer(0, 8), round % 2 == 0, degree);
    const BezierPatches patches(surface);
    const SurfaceBounds bounds(patches);
    for (int i = 0; i < 20; ++i) {
      const ParameterBox part = random_part(random, patches.domain());
      std::array<Vec2, 3> uvs;
      std::array<Vec3, 3> corners;
      for (std::size_t k = 0; k < 3; ++k) {
        uvs[k] = random_place(random, part);
        corners[k] = patches.evaluate(uvs[k]);
      }
      const double bound = bounds.deviation(uvs).total();
      EXPECT_GE(bounds.deviation(uvs, 1.0).total(), bound * (1 - 1e-12));
      EXPECT_TRUE(bounds.deviation(uvs, 1.0).total() <= 1 ||
                  bounds.deviation(uvs, 1.0).total() <= bound * (1 + 1e-12));
      for (int k = 0; k < 30; ++k) {
        Vec3 shares(random.number(0, 1), random.number(0, 1), random.number(0, 1));
        shares /= shares.sum();
        const Vec2 uv = shares[0] * uvs[0] + shares[1] * uvs[1] + shares[2] * uvs[2];
        const Vec3 on_triangle = shares[0] * corners[0] + shares[1] * corners[1] + shares[2] * corners[2];
        // Of the evaluation itself.
        EXPECT_LE((patches.evaluate(uv) - on_triangle).norm(), bound + 1e-13);
      }
    }
  }
}

TEST(SurfaceBounds, AreNearToWhatTheyBound) {
  // A quarter tube of radius 1: the second derivative along u is 2 sqrt(2) - 2 + ... at most 1.66 at its
  // ends.
  const BezierPatches patches(test::quarter_tube(1, 5));
  const SurfaceBounds bounds(patches);
  double most = 0;
  for (double u = 0; u <= 1; u += 1.0 / 64) most = std::max(most, patches.derivatives({u, 0.5}).duu.norm());
  // Pieces are halved until bounds are within 1.5 times what they bound.
  EXPECT_LT(bounds.derivatives(patches.domain()).uu, 1.5 * most);
  // A strip of a hundredth of the way around deviates by an eighth of its square times the derivative.
  const ParameterBox strip(Vec2(0.5, 0), Vec2(0.51, 1));
  const double derivative = patches.derivatives({0.505, 0.5}).duu.norm();
  EXPECT_NEAR(bounds.deviation(strip.min(), strip.max()), 1e-4 / 8 * derivative, 0.5 * 1e-4 / 8 * derivative);
  // Its normals turn by a quarter, and the cone reaches a little farther.
  const NormalCone cone = bounds.normal_cone(patches.domain());
  EXPECT_GT(cone.angle, std::numbers::pi / 4);
  EXPECT_LT(cone.angle, std::numbers::pi / 3);
  EXPECT_GT(cone.axis.dot(Vec3(1, 1, 0).normalized()), 0.95);
}

TEST(SurfaceBounds, OfAPlaneAreNothing) {
  NurbsSurface plane{{1, 1},
                     {std::vector<double>{0, 0, 1, 1}, {0, 0, 1, 1}},
                     {{5, 5, 1}, {5, 7, 1}, {8, 5, 1}, {8, 7, 1}},
                     {}};
  const SurfaceBounds bounds{BezierPatches(plane)};
  EXPECT_EQ(bounds.deviation({Vec2(0, 0), Vec2(1, 1), Vec2(0, 1)}).total(), 0);
  EXPECT_LT(bounds.normal_cone({Vec2(0, 0), Vec2(1, 1)}).angle, 1e-5);
}

TEST(PatchSurface, KnowsInHowManyWaysItBends) {
  EXPECT_EQ(PatchSurface(test::parallelogram({1, 2, 3}, {3, 0, 1}, {0, 2, 0})).bend, SurfaceBend::none);
  NurbsSurface twisted = test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  twisted.points[3].z() += 1e-6;
  EXPECT_EQ(PatchSurface(twisted).bend, SurfaceBend::both);
  EXPECT_EQ(PatchSurface(test::can(2, 3)[0].surface).bend, SurfaceBend::one_way);
  EXPECT_EQ(PatchSurface(test::ball(1)).bend, SurfaceBend::both);
}

// Four quarters of a circle have derivatives without jumps, though those of weights and points jump.
TEST(SurfaceBounds, SeeNoKinksWhereCirclesArePutTogether) {
  const SurfaceBounds bounds{BezierPatches(test::ball(10))};
  // Across two lines of knots: half of the circumference is far away, but nothing is bent sharply.
  EXPECT_LT(bounds.deviation({Vec2(0.9, 0.9), Vec2(1.1, 0.9), Vec2(1.1, 1.1)}).kink, 1e-12);
  // A triangle that touches a line of knots by rounding has the bound of one beside it.
  const double beside = bounds.deviation({Vec2(1, 0.5), Vec2(1.2, 0.5), Vec2(1.2, 0.7)}).total();
  const double across = bounds.deviation({Vec2(1 - 1e-15, 0.5), Vec2(1.2, 0.5), Vec2(1.2, 0.7)}).total();
  EXPECT_LT(across, 1.5 * beside);
}

// The nearer to a pole, the smaller is what lies around it.
TEST(SurfaceBounds, GoToNothingTowardTheTipOfACone) {
  const double w = std::numbers::sqrt2 / 2;
  const NurbsSurface cone{{2, 1},
                          {std::vector<double>{0, 0, 0, 1, 1, 1}, {0, 0, 1, 1}},
                          {{0, 0, 1}, {1, 0, 0}, {0, 0, 1}, {1, 1, 0}, {0, 0, 1}, {0, 1, 0}},
                          {1, 1, w, w, 1, 1}};
  const SurfaceBounds bounds{BezierPatches(cone)};
  for (const double height : {0.1, 0.01, 0.001}) {
    // A quarter of a circle around the tip is as high over its chord as 1 - cos(45 degrees) of its radius;
    // bounds by derivatives are within three times that, and nodes reach up to twice as far.
    EXPECT_LT(bounds.deviation({Vec2(0, 0), Vec2(1, 0), Vec2(0.5, height)}).total(), 6 * (1 - w) * height);
  }
}

TEST(SurfaceBounds, KnowNoNormalsAroundAPole) {
  const BezierPatches ball(test::ball(1));
  const SurfaceBounds bounds(ball);
  EXPECT_GT(bounds.normal_cone({Vec2(0, 1.9), Vec2(4, 2)}).angle, std::numbers::pi);
  EXPECT_LT(bounds.normal_cone({Vec2(0, 0.9), Vec2(0.5, 1.1)}).angle, 1.0);
}

}  // namespace
}  // namespace recede
