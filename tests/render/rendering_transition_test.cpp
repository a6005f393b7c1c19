#include <recede/geometry/error.h>
#include <recede/render/rendering_transition.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

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

TEST(RenderingTransition, AroundADistanceAllMethodsHaveAPlace) {
  // 1 / d = (2 + e (cos + 0.1)) / 2 in units of the distance.
  const TransitionOptions options = transition_around(10);
  const std::array<double, 4> straight{22.22, 11.98, 8.58, 6.45}, aside{10.53, 10.15, 9.85, 9.52};
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(transition_distance(k_transition_values[k], 1, options), straight[k], 0.01);
    EXPECT_NEAR(transition_distance(k_transition_values[k], 0, options), aside[k], 0.01);
    // Twice the distance moves all of them by twice.
    EXPECT_NEAR(transition_distance(k_transition_values[k], 0.3, transition_around(20)),
                2 * transition_distance(k_transition_values[k], 0.3, options), 1e-12);
  }
  EXPECT_NEAR(transition_value(10, 0.7, options), 0, 1e-15);
  EXPECT_LT(transition_value(1e-9, 0.7, transition_around(0)), -1);  // flat: the table from everywhere
}

TEST(RenderingTransition, AWaveCoversTwoPixelsWhereItIsAZero) {
  // 0.2 long; pixels of 0.01 at the distance 1 are 0.1 at 10.
  EXPECT_NEAR(transition_value(10, 1, transition_for_wavelength(0.2, 0.01)), 0, 1e-15);
}

TEST(RenderingTransition, NumbersOutOfRangeAreRefused) {
  EXPECT_THROW(transition_value(0, 1), OptionError);
  EXPECT_THROW(transition_value(std::nan(""), 1), OptionError);
  EXPECT_THROW(transition_value(1, 1, {.threshold = 1, .silhouette = 0}), OptionError);
}

}  // namespace
}  // namespace recede
