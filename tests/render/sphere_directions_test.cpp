#include <recede/geometry/error.h>
#include <recede/render/sphere_directions.h>

#include <gtest/gtest.h>

#include <numbers>
#include <numeric>
#include <random>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;

TEST(SphereDirections, CoverTheSphereEvenlyAndNeverLevel) {
  for (const int count : {6, 7, 40, 100, 101, 256}) {
    const SphereDirections sphere = spread_directions(count);
    ASSERT_EQ(sphere.size(), static_cast<std::size_t>(count));
    Vec3 sum = Vec3::Zero();
    for (const Vec3& d : sphere.directions) {
      EXPECT_NEAR(d.norm(), 1, 1e-15);
      EXPECT_GT(std::abs(d.z()), 0.4 / count);
      sum += d / count;
    }
    // Evenly spread, they cancel: random ones would leave 1 / sqrt(count).
    EXPECT_LT(sum.norm(), 1.0 / count) << count;
  }
}

TEST(SphereDirections, IntegrateACosineOverAnyHemisphere) {
  std::mt19937 random(1);
  std::normal_distribution<double> number(0, 1);
  const SphereDirections sphere = spread_directions(100);
  double squares = 0;
  constexpr int k_count = 500;
  for (int i = 0; i < k_count; ++i) {
    const Vec3 normal = Vec3(number(random), number(random), number(random)).normalized();
    double sum = 0;
    for (const Vec3& d : sphere.directions) sum += std::max(0.0, d.dot(normal)) * 4 * k_pi / 100;
    squares += (sum / k_pi - 1) * (sum / k_pi - 1) / k_count;
  }
  // 0.23 % is known of Fibonacci's spiral; random directions have 13 %.
  EXPECT_LT(std::sqrt(squares), 0.003);
}

TEST(SphereDirections, AreJoinedByTrianglesThatNoDirectionLiesAbove) {
  for (const int count : {6, 9, 33, 128}) {
    const SphereDirections sphere = spread_directions(count);
    ASSERT_EQ(sphere.triangles.size(), 2 * sphere.size() - 4) << "of a closed surface like a sphere";
    for (const DirectionTriangle& t : sphere.triangles) {
      const auto at = [&](std::size_t k) { return sphere.directions[static_cast<std::size_t>(t[k])]; };
      const Vec3 normal = (at(1) - at(0)).cross(at(2) - at(0));
      EXPECT_GT(normal.dot(at(0)), 0) << "the middle of the sphere is inside";
      for (const Vec3& d : sphere.directions) EXPECT_LT(normal.dot(d - at(0)), 1e-14);
    }
    const std::vector<double> angles = solid_angles(sphere.directions, sphere.triangles);
    EXPECT_NEAR(std::accumulate(angles.begin(), angles.end(), 0.0), 4 * k_pi, 1e-12);
    if (count < 100) continue;
    for (const double angle : angles) {
      // Of 100 directions they are known to be 0.81 to 1.23 of the mean.
      EXPECT_GT(angle, 0.75 * 4 * k_pi / count);
      EXPECT_LT(angle, 1.25 * 4 * k_pi / count);
    }
  }
}

TEST(SphereDirections, MixToAnyOtherDirection) {
  std::mt19937 random(2);
  std::normal_distribution<double> number(0, 1);
  const SphereDirections sphere = spread_directions(64);
  for (int i = 0; i < 500; ++i) {
    const Vec3 wanted = Vec3(number(random), number(random), number(random)).normalized();
    const DirectionMix mix = mix_of_three(sphere.directions, sphere.triangles, wanted);
    Vec3 mixed = Vec3::Zero();
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_GE(mix.weights[k], 0);
      sum += mix.weights[k];
      mixed += mix.weights[k] * sphere.directions[static_cast<std::size_t>(mix.directions[k])];
    }
    EXPECT_NEAR(sum, 1, 1e-14);
    EXPECT_LT((mixed.normalized() - wanted).norm(), 1e-12);
    const std::size_t nearest = nearest_direction(sphere.directions, wanted);
    for (const Vec3& d : sphere.directions) EXPECT_LE(d.dot(wanted), sphere.directions[nearest].dot(wanted));
  }
  for (std::size_t i = 0; i < sphere.size(); ++i)
    EXPECT_EQ(nearest_direction(sphere.directions, 3 * sphere.directions[i]), i);
}

TEST(SphereDirections, CountNothingForTrianglesThatTurnedOver) {
  SphereDirections sphere = spread_directions(32);
  sphere.directions[10] = -sphere.directions[10];
  for (const double angle : solid_angles(sphere.directions, sphere.triangles)) EXPECT_GE(angle, 0);
  EXPECT_THROW(spread_directions(0), OptionError);
  EXPECT_THROW(spread_directions(5), OptionError);
  EXPECT_THROW(spread_directions(4097), OptionError);
}

}  // namespace
}  // namespace recede
