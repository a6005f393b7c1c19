#include <recede/render/detail/quick_square.h>
#include <recede/render/hemisphere_square.h>

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace recede::detail {
namespace {

TEST(QuickSquare, IsTheSquareOfDirectionsToNineDigits) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(0, 1);
  for (int i = 0; i < 100'000; ++i) {
    const Vec2 place(number(random), number(random));
    const Vec3 direction = square_to_hemisphere(place), quick = quick_square_to_hemisphere(place);
    ASSERT_LT((quick - direction).norm(), 1e-9) << place.transpose();
    ASSERT_NEAR(quick.norm(), 1, 1e-15);
    ASSERT_LT((quick_hemisphere_to_square(direction) - place).norm(), 1e-9) << direction.transpose();
  }
}

TEST(QuickSquare, HasTheSameMiddleSidesCornersAndHorizon) {
  for (const double a : {0.0, 0.5, 1.0}) {
    for (const double b : {0.0, 0.5, 1.0}) {
      const Vec3 direction = square_to_hemisphere({a, b});
      EXPECT_LT((quick_square_to_hemisphere({a, b}) - direction).norm(), 1e-9) << a << ' ' << b;
      EXPECT_LT((quick_hemisphere_to_square(direction) - Vec2(a, b)).norm(), 1e-9) << a << ' ' << b;
    }
  }
  EXPECT_EQ(quick_hemisphere_to_square(Vec3(0.6, 0, -0.8)), Vec2(1, .5)) << "below the horizon";
}

TEST(QuickSquare, HasAnglesOfAQuarter) {
  for (int degrees = 0; degrees <= 90; ++degrees) {
    const double angle = degrees * std::numbers::pi / 180;
    EXPECT_NEAR(quick_angle(3 * std::cos(angle), 3 * std::sin(angle)), degrees / 90.0, 2e-10) << degrees;
  }
  EXPECT_EQ(quick_angle(0, 0), 0);
}

}  // namespace
}  // namespace recede::detail
