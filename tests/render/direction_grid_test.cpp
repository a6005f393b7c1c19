#include <recede/render/direction_grid.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;

const DirectionGrid k_views{.side = 7, .whole_sphere = false}, k_lights{.side = 7, .whole_sphere = true};

std::vector<double> by_node(const DirectionGrid& grid, const NodeMix& mix) {
  std::vector<double> weights(grid.size(), 0.0);
  for (std::size_t k = 0; k < 4; ++k) weights[static_cast<std::size_t>(mix.nodes[k])] += mix.weights[k];
  return weights;
}

Vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> number(0, 1);
  return Vec3(number(random), number(random), number(random)).normalized();
}

TEST(DirectionGrid, HasFortyNineViewsAndNinetyEightLightsOfWhichNoneIsLevel) {
  ASSERT_EQ(k_views.size(), 49U);
  ASSERT_EQ(k_lights.size(), 98U);
  // Half a cell inside the square's border the disk has the radius 6/7, and the height is 1 - 36/49.
  const double lowest = 13.0 / 49;
  for (std::size_t node = 0; node < 49; ++node) {
    const Vec3 front = k_lights.direction(node), back = k_lights.direction(49 + node);
    EXPECT_NEAR(front.norm(), 1, 1e-15);
    EXPECT_GE(front.z(), lowest - 1e-15) << node;
    EXPECT_EQ(front, k_views.direction(node));
    EXPECT_EQ(back, Vec3(front.x(), front.y(), -front.z()));
  }
  EXPECT_EQ(k_views.direction(24), Vec3::UnitZ());
  EXPECT_NEAR(k_views.direction(27).x(), std::sqrt(1 - lowest * lowest), 1e-15)
      << "the end of the middle row";
  EXPECT_NEAR(k_views.direction(27).z(), lowest, 1e-15);
}

TEST(DirectionGrid, StandsForEqualSolidAngles) {
  // So a sum is an integral: the error of taking cells by their middles falls with their area. Most of it is
  // that of those on diagonals, where the height has a kink.
  for (const int side : {7, 14, 28}) {
    const DirectionGrid grid{.side = side, .whole_sphere = true};
    double cosine = 0;
    for (std::size_t node = 0; node < grid.size(); ++node)
      cosine += std::max(0.0, grid.direction(node).z()) * 4 * k_pi / static_cast<double>(grid.size());
    EXPECT_NEAR(cosine, k_pi, 2.05 * k_pi / (side * side)) << side;
  }
}

TEST(DirectionGrid, GivesANodeAloneForItsOwnDirection) {
  for (const DirectionGrid& grid : {k_views, k_lights, DirectionGrid{16, true}, DirectionGrid{2, false}}) {
    for (std::size_t node = 0; node < grid.size(); ++node) {
      const std::vector<double> weights = by_node(grid, grid.mix(grid.direction(node)));
      EXPECT_NEAR(weights[node], 1, 1e-13) << "node " << node << " of " << grid.size();
    }
  }
}

TEST(DirectionGrid, MixesByWeightsThatSumToOneWithNodesThatAreNear) {
  std::mt19937 random(1);
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 direction = random_direction(random);
    const NodeMix mix = k_lights.mix(direction);
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      ASSERT_GE(mix.weights[k], 0);
      ASSERT_GE(mix.nodes[k], 0);
      ASSERT_LT(mix.nodes[k], 98);
      sum += mix.weights[k];
      // The widest cells are those at the corners of the square, where one is 40 degrees along the horizon.
      if (mix.weights[k] > 0) {
        ASSERT_GT(k_lights.direction(static_cast<std::size_t>(mix.nodes[k])).dot(direction),
                  std::cos(45 * k_pi / 180))
            << direction.transpose();
      }
    }
    ASSERT_NEAR(sum, 1, 1e-14);
  }
}

TEST(DirectionGrid, IsContinuousEverywhere) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> number(0, 1);
  constexpr double k_step = 1e-7;
  for (int i = 0; i < 60'000; ++i) {
    Vec3 direction = random_direction(random);
    // A third each: anywhere, about the horizon, and about the corners of the square, which lie on it.
    if (i % 3 > 0) direction.z() *= k_step;
    if (i % 3 == 2) {
      const double azimuth = k_pi / 4 + std::floor(4 * number(random)) * k_pi / 2;
      direction = Vec3(std::cos(azimuth), std::sin(azimuth), 0) + k_step * direction;
    }
    direction.normalize();
    const Vec3 near = (direction + k_step * random_direction(random)).normalized();
    for (const DirectionGrid& grid : {k_views, k_lights}) {
      // Below the horizon of a hemisphere alone, the straight way down is every azimuth at once.
      if (!grid.whole_sphere && direction.z() < -0.1) continue;
      const std::vector<double> from = by_node(grid, grid.mix(direction)), to = by_node(grid, grid.mix(near));
      // Seven cells a side, in each of which a weight goes from 0 to 1 along two axes, and a map that nowhere
      // stretches an angle to more than 0.7 times as much of the square.
      for (std::size_t node = 0; node < grid.size(); ++node)
        ASSERT_NEAR(from[node], to[node], 2 * 0.7 * 7 * k_step) << direction.transpose();
    }
  }
}

TEST(DirectionGrid, CountsBothSidesOfTheHorizonAlikeOnIt) {
  std::mt19937 random(3);
  for (int i = 0; i < 1000; ++i) {
    Vec3 level = random_direction(random);
    level.z() = 0;
    level.normalize();
    const std::vector<double> weights = by_node(k_lights, k_lights.mix(level));
    for (std::size_t node = 0; node < 49; ++node) ASSERT_NEAR(weights[node], weights[49 + node], 1e-14);
    // A hemisphere alone has the same from its lowest nodes down.
    const std::vector<double> half = by_node(k_views, k_views.mix(level));
    for (std::size_t node = 0; node < 49; ++node) ASSERT_NEAR(half[node], 2 * weights[node], 1e-13);
    const Vec3 below(0.6 * level.x(), 0.6 * level.y(), -0.8);
    const std::vector<double> lowest = by_node(k_views, k_views.mix(below));
    for (std::size_t node = 0; node < 49; ++node) ASSERT_NEAR(lowest[node], half[node], 1e-13);
  }
}

/// The largest error of a smooth function from its values at nodes.
double interpolation_error(const DirectionGrid& grid) {
  const auto value = [](const Vec3& d) { return d.x() * d.y() + d.z() * d.z() + 0.5 * d.x(); };
  std::mt19937 random(4);
  double worst = 0;
  for (int i = 0; i < 50'000; ++i) {
    const Vec3 direction = random_direction(random);
    const NodeMix mix = grid.mix(direction);
    double mixed = 0;
    for (std::size_t k = 0; k < 4; ++k)
      mixed += mix.weights[k] * value(grid.direction(static_cast<std::size_t>(mix.nodes[k])));
    worst = std::max(worst, std::abs(mixed - value(direction)));
  }
  return worst;
}

TEST(DirectionGrid, InterpolatesSmoothFunctionsWithAnErrorThatFallsWithItsCells) {
  // A function from -0.9 to 1.1. Quartered by halved cells where the square is smooth, halved across its
  // diagonals and the horizon, where it has kinks.
  double last = interpolation_error({.side = 7, .whole_sphere = true});
  EXPECT_LT(last, 0.16);
  for (const int side : {14, 28, 56}) {
    const double error = interpolation_error({.side = side, .whole_sphere = true});
    EXPECT_LT(error, 0.6 * last) << side;
    last = error;
  }
}

}  // namespace
}  // namespace recede
