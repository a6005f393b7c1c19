#include "chart_sphere.h"
#include <recede/geometry/error.h>
#include <recede/render/displaced_mesh.h>
#include <recede/render/rendering_transition.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace recede {
namespace {

TEST(RenderingTransition, MethodsChangeAtTheSpecifiedDistances) {
  struct Row {
    double threshold, cosine;
    std::array<double, 4> distances;  // of T = -1, -0.3, 0.3, 1
  };
  constexpr double k_never = std::numeric_limits<double>::infinity();
  for (const Row& row :
       {Row{1, 1, {k_never, 1.493, 0.752, 0.476}}, Row{1, 0.5, {2.5, 1.220, 0.847, 0.625}},
        Row{1, 0, {1.111, 1.031, 0.971, 0.909}}, Row{3, 1, {0.526, 0.375, 0.300, 0.244}},
        Row{0.3, 1, {k_never, k_never, 1.587, 0.714}}, Row{1.3, 1, {5, 1.031, 0.613, 0.417}}}) {
    const TransitionOptions options{.threshold = row.threshold};
    for (std::size_t k = 0; k < 4; ++k) {
      const double distance = transition_distance(k_transition_values[k], row.cosine, options);
      if (std::isinf(row.distances[k])) {
        EXPECT_TRUE(std::isinf(distance));
        continue;
      }
      EXPECT_NEAR(distance, row.distances[k], 0.0006);  // the table has three decimals
      EXPECT_NEAR(transition_value(distance, row.cosine, options), k_transition_values[k], 1e-12);
    }
  }
}

TEST(RenderingTransition, ItsValueFallsWithDistanceAndGrowsAlongSilhouettes) {
  double before = std::numeric_limits<double>::infinity();
  for (double distance = 0.1; distance < 20; distance *= 1.1) {
    const double value = transition_value(distance, 0.7);
    EXPECT_LT(value, before);
    EXPECT_EQ(value > 0, distance < 1);
    EXPECT_GE(std::abs(transition_value(distance, 0.1)), std::abs(value));
    before = value;
  }
}

TEST(RenderingTransition, ProgressRunsFromNothingToAllWithinTransitionsOnly) {
  EXPECT_EQ(rendering_transition(-1.01).method, RenderingMethod::brdf);
  EXPECT_EQ(rendering_transition(-1).method, RenderingMethod::brdf_to_bump);
  EXPECT_EQ(rendering_transition(-1).progress, 0);
  EXPECT_NEAR(rendering_transition(-0.65).progress, 0.5, 1e-12);
  EXPECT_NEAR(rendering_transition(-0.3000001).progress, 1, 1e-6);
  EXPECT_EQ(rendering_transition(0).method, RenderingMethod::bump);
  EXPECT_EQ(rendering_transition(0.3).method, RenderingMethod::bump_to_displacement);
  EXPECT_NEAR(rendering_transition(0.65).progress, 0.5, 1e-12);
  EXPECT_EQ(rendering_transition(1).progress, 1);
  EXPECT_EQ(rendering_transition(1.01).method, RenderingMethod::displacement);
}

TEST(RenderingTransition, ALoweredMapStaysWithinItsBase) {
  for (const bool floats : {false, true}) {
    const DisplacementMap map = floats ? test::rough_float_map(30, 20, -0.1, 0.2, MapBorder::clamped, 3)
                                       : test::rough_map(30, 20, -0.1, 0.2, MapBorder::clamped, 3);
    const DisplacementMap lowered = lowered_below_base(map);
    double highest = -1;
    for (int y = 0; y < 20; ++y) {
      for (int x = 0; x < 30; ++x) {
        highest = std::max(highest, lowered.texel(x, y));
        EXPECT_NEAR(lowered.texel(x, y) - lowered.texel(0, 0), map.texel(x, y) - map.texel(0, 0), 1e-7);
      }
    }
    EXPECT_NEAR(highest, 0, 1e-15);
    DisplacedMeshOptions options;
    options.level = 4;
    const PolygonSoup base = test::chart_sphere(4, Vec3::Zero());
    const DisplacedMesh displaced(base, lowered, options), bare(base, DisplacementMap(1, 1, {0.0f}), options);
    std::mt19937 random(2);
    std::normal_distribution<double> normal;
    for (int k = 0; k < 2000; ++k) {
      const Vec3 from = 2 * Vec3(normal(random), normal(random), normal(random)).normalized();
      const Vec3 to = Vec3(normal(random), normal(random), normal(random)).normalized();
      const auto hit = displaced.first_hit(from, to - from), first = bare.first_hit(from, to - from);
      if (!hit) continue;
      ASSERT_TRUE(first);
      EXPECT_GE(hit->t, first->t - 1e-6);  // some steps of float
    }
  }
}

TEST(RenderingTransition, NumbersOutOfRangeAreRefused) {
  EXPECT_THROW(transition_value(0, 1), OptionError);
  EXPECT_THROW(transition_value(std::nan(""), 1), OptionError);
  EXPECT_THROW(transition_value(1, 1, {.threshold = 1, .silhouette = 0}), OptionError);
}

}  // namespace
}  // namespace recede
