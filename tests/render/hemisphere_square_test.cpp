#include <recede/render/hemisphere_square.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace recede {
namespace {

TEST(HemisphereSquare, LeadsThereAndBack) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(0, 1);
  for (int i = 0; i < 100'000; ++i) {
    const Vec2 place(number(random), number(random));
    const Vec3 direction = square_to_hemisphere(place);
    ASSERT_NEAR(direction.norm(), 1, 1e-15);
    ASSERT_GE(direction.z(), 0);
    ASSERT_LT((hemisphere_to_square(direction) - place).cwiseAbs().maxCoeff(), 1e-12) << place.transpose();
    const double height = number(random), angle = 2 * std::numbers::pi * number(random);
    const double level = std::sqrt(1 - height * height);
    const Vec3 other(level * std::cos(angle), level * std::sin(angle), height);
    ASSERT_LT((square_to_hemisphere(hemisphere_to_square(other)) - other).norm(), 1e-12) << other.transpose();
  }
}

TEST(HemisphereSquare, KeepsDigitsNearItsPole) {
  // The disk's radius is 1e-9 / sqrt(2), where 1 - z alone would be 0.
  const Vec2 place = hemisphere_to_square(Vec3(1e-9, 0, 1).normalized());
  EXPECT_NEAR(2 * place.x() - 1, 1e-9 / std::numbers::sqrt2, 1e-16);
  EXPECT_EQ(place.y(), 0.5);
}

TEST(HemisphereSquare, HasItsMiddleItsSidesAndItsCornersWhereTheyBelong) {
  const double s = std::numbers::sqrt2 / 2;
  const std::pair<Vec2, Vec3> pairs[] = {{{.5, .5}, {0, 0, 1}}, {{1, .5}, {1, 0, 0}},  {{0, .5}, {-1, 0, 0}},
                                         {{.5, 1}, {0, 1, 0}},  {{.5, 0}, {0, -1, 0}}, {{1, 1}, {s, s, 0}},
                                         {{0, 1}, {-s, s, 0}},  {{1, 0}, {s, -s, 0}},  {{0, 0}, {-s, -s, 0}}};
  for (const auto& [place, direction] : pairs) {
    EXPECT_LT((square_to_hemisphere(place) - direction).norm(), 1e-15) << place.transpose();
    EXPECT_LT((hemisphere_to_square(direction) - place).norm(), 1e-15) << place.transpose();
  }
  EXPECT_EQ(hemisphere_to_square(Vec3(0.6, 0, -0.8)), Vec2(1, .5)) << "below the horizon";
}

TEST(HemisphereSquare, KeepsAreas) {
  // The solid angle of small squares, from cross products of their sides, is 2 pi times their area. Squares
  // that touch a diagonal have a kink.
  constexpr int k_side = 40;
  const double step = 1e-4;
  for (int x = 0; x < k_side; ++x) {
    for (int y = 0; y < k_side; ++y) {
      if (x == y || x + y == k_side - 1) continue;
      const Vec2 middle((x + 0.5) / k_side, (y + 0.5) / k_side);
      const Vec3 along_a =
          square_to_hemisphere(middle + Vec2(step, 0)) - square_to_hemisphere(middle - Vec2(step, 0));
      const Vec3 along_b =
          square_to_hemisphere(middle + Vec2(0, step)) - square_to_hemisphere(middle - Vec2(0, step));
      const double area = along_a.cross(along_b).norm() / (4 * step * step);
      // Differences err by the third derivatives times step^2, which are hundreds near the corners.
      EXPECT_NEAR(area, 2 * std::numbers::pi, 1e-5) << x << ' ' << y;
    }
  }
}

}  // namespace
}  // namespace recede
