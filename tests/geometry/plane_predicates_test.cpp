#include "plane_integers.h"
#include <recede/geometry/detail/plane_predicates.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace recede {
namespace {

using detail::orientation;
using detail::side_of_circle;

TEST(PlanePredicates, AreThoseOfWholeNumbersAtEveryScale) {
  std::mt19937 random(1);
  std::size_t zeros = 0;
  for (int i = 0; i < 20000; ++i) {
    const int range = i % 2 == 0 ? 7 : 1 << 25;
    const auto coordinate = [&] { return static_cast<double>(static_cast<int>(random()) % range); };
    Vec2 p[4];
    for (Vec2& q : p) q = {coordinate(), coordinate()};
    if (i % 5 == 0) {  // a square, turned
      p[2] = p[1] + Vec2(p[0].y() - p[1].y(), p[1].x() - p[0].x());
      p[3] = p[0] + p[2] - p[1];
    }
    const int turn = test::whole_orientation(p[0], p[1], p[2]);
    const int side = test::whole_side_of_circle(p[0], p[1], p[2], p[3]);
    if (turn == 0) ++zeros;
    if (side == 0) ++zeros;
    // Products are too small or too large for doubles at the outer ones; the last but one is where small
    // coordinates have fewer places than large ones.
    for (const int exponent : {0, -60, 200, 900, -270, -1040, -1074}) {
      Vec2 q[4];
      for (int k = 0; k < 4; ++k) q[k] = {std::ldexp(p[k].x(), exponent), std::ldexp(p[k].y(), exponent)};
      ASSERT_EQ(orientation(q[0], q[1], q[2]), turn) << i << ' ' << exponent;
      ASSERT_EQ(side_of_circle(q[0], q[1], q[2], q[3]), side) << i << ' ' << exponent;
    }
    ASSERT_EQ(detail::exact_orientation(p[0], p[1], p[2]), turn) << i;
    ASSERT_EQ(detail::exact_side_of_circle(p[0], p[1], p[2], p[3]), side) << i;
  }
  EXPECT_GT(zeros, 4000u);
}

TEST(PlanePredicates, AxesOfDifferentScalesDontChangeOrientation) {
  std::mt19937_64 random(3);
  std::size_t zeros = 0;
  for (int i = 0; i < 5000; ++i) {
    // All 53 places, on a line or one unit off it.
    const auto coordinate = [&](int bits) { return static_cast<double>(random() >> (64 - bits)); };
    const Vec2 step(coordinate(40), coordinate(40)), a(coordinate(51), coordinate(51));
    const Vec2 b = a + coordinate(10) * step;
    const Vec2 c = a + coordinate(10) * step + Vec2(0, static_cast<double>(i % 3 - 1));
    const test::WholePoint p(a), q(b), r(c);
    const int expected =
        test::sign_of(test::Wide{q.x - p.x} * (r.y - p.y) - test::Wide{q.y - p.y} * (r.x - p.x));
    zeros += expected == 0 ? 1 : 0;
    for (const int x : {0, 11, 37, 100, 700, -900}) {
      const auto scaled = [&](const Vec2& v) { return Vec2(std::ldexp(v.x(), x), std::ldexp(v.y(), x / 3)); };
      ASSERT_EQ(orientation(scaled(a), scaled(b), scaled(c)), expected) << i << ' ' << x;
      ASSERT_EQ(detail::exact_orientation(scaled(a), scaled(b), scaled(c)), expected) << i << ' ' << x;
    }
  }
  EXPECT_GT(zeros, 1000u);
}

TEST(PlanePredicates, AStepOfAnyLengthLeadsIntoACircleOrOutOfIt) {
  // From the origin, a corner of a square with whole coordinates: inward when it leads towards the opposite
  // corner, and also when it runs along the tangent, only outward.
  std::mt19937 random(4);
  for (int i = 0; i < 3000; ++i) {
    const auto coordinate = [&] { return static_cast<double>(static_cast<int>(random()) % (1 << 25)); };
    const Vec2 a(coordinate(), coordinate()), c(-a.y(), a.x()), opposite = a + c;
    const Vec2 step(static_cast<int>(random()) % 100, static_cast<int>(random()) % 100);
    const Vec2 tangent(-opposite.y(), opposite.x());
    if (a.isZero() || step.isZero()) continue;
    const double along = opposite.dot(step);
    for (const int exponent : {-60, -200, -700, -1074}) {
      const Vec2 inward(std::ldexp(step.x(), exponent), std::ldexp(step.y(), exponent));
      ASSERT_EQ(side_of_circle(a, opposite, c, inward), along > 0 ? 1 : -1) << i << ' ' << exponent;
      const Vec2 outward(std::ldexp(tangent.x(), exponent), std::ldexp(tangent.y(), exponent));
      ASSERT_EQ(side_of_circle(a, opposite, c, outward), -1) << i << ' ' << exponent;
    }
  }
}

TEST(PlanePredicates, KeepTheirSignsFarFromTheOrigin) {
  std::mt19937 random(2);
  for (int i = 0; i < 5000; ++i) {
    Vec2 p[4], moved[4];
    for (Vec2& q : p) q = {random() % 16, random() % 16};
    // One unit in the last place there.
    for (int k = 0; k < 4; ++k) moved[k] = p[k] + Vec2(0x1p52, -0x1p52);
    ASSERT_EQ(orientation(moved[0], moved[1], moved[2]), test::whole_orientation(p[0], p[1], p[2]));
    ASSERT_EQ(side_of_circle(moved[0], moved[1], moved[2], moved[3]),
              test::whole_side_of_circle(p[0], p[1], p[2], p[3]));
  }
}

TEST(PlanePredicates, SeeTheLastPlaceOfACoordinate) {
  for (const double x : {0.1, 1e-5, 12345.678, 1e-300, 1e300, 4e-320}) {
    const double above = std::nextafter(x, 1e308), below = std::nextafter(x, 0.0);
    for (const double far : {1.0, 1e300, 3e-310}) {
      const Vec2 begin(-far, -far), end(far, far);
      EXPECT_EQ(orientation(begin, end, {x, x}), 0) << x << ' ' << far;
      EXPECT_EQ(orientation(begin, end, {x, above}), 1) << x << ' ' << far;
      EXPECT_EQ(orientation(begin, end, {x, below}), -1) << x << ' ' << far;
    }
    const Vec2 right(x, 0), top(0, x), left(-x, 0);
    EXPECT_EQ(side_of_circle(right, top, left, {0, -x}), 0) << x;
    EXPECT_EQ(side_of_circle(right, top, left, {0, -below}), 1) << x;
    EXPECT_EQ(side_of_circle(right, top, left, {0, -above}), -1) << x;
  }
}

TEST(PlanePredicates, AreExactWhereRoundingDecidesWrongly) {
  // A point a few units in the last place off the diagonal: the sign is that of y - x.
  for (int i = -40; i <= 40; ++i) {
    for (int j = -40; j <= 40; ++j) {
      const Vec2 p(0.5 + i * 0x1p-53, 0.5 + j * 0x1p-53);
      const int expected = p.y() > p.x() ? 1 : p.y() < p.x() ? -1 : 0;
      EXPECT_EQ(orientation({12, 12}, {24, 24}, p), expected);
      EXPECT_EQ(orientation({24, 24}, {12, 12}, p), -expected);
      EXPECT_EQ(orientation(p, {12, 12}, {24, 24}), expected);
    }
  }
}

TEST(PlanePredicates, MixTheSmallestNumbersWithTheLargest) {
  const double large = 1.7e308, small = 5e-324;
  EXPECT_EQ(orientation({-large, 0}, {large, 0}, {0, small}), 1);
  EXPECT_EQ(orientation({-large, 0}, {large, small}, {large, 0}), -1);
  EXPECT_EQ(orientation({-large, -large}, {large, large}, {small, 0}), -1);
  // The circle over a diameter bulges by far less than the smallest number, but bulges.
  EXPECT_EQ(side_of_circle({large, 0}, {0, large}, {-large, 0}, {small, small}), 1);
  EXPECT_EQ(side_of_circle({large, 0}, {0, large}, {-large, 0}, {-large, small}), -1);
  EXPECT_EQ(side_of_circle({small, 0}, {0, small}, {-small, 0}, {0, -large}), -1);
}

}  // namespace
}  // namespace recede
