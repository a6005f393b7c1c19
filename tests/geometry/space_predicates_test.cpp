#include <recede/geometry/detail/space_predicates.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>

namespace recede {
namespace {

using detail::side_of_plane;

__extension__ using Wide = __int128;

/// For whole coordinates below 2^38.
int whole_side_of_plane(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  Wide m[3][3];
  const Vec3* const points[] = {&b, &c, &d};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      m[i][k] = static_cast<std::int64_t>((*points[i])[k]) - static_cast<std::int64_t>(a[k]);
    }
  }
  const Wide value = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) +
                     m[0][1] * (m[1][2] * m[2][0] - m[1][0] * m[2][2]) +
                     m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  return value > 0 ? 1 : value < 0 ? -1 : 0;
}

TEST(SpacePredicates, AreThoseOfWholeNumbersAtEveryScale) {
  std::mt19937_64 random(1);
  std::size_t zeros = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::int64_t range = i % 2 == 0 ? 5 : std::int64_t{1} << 38;
    const auto coordinate = [&] {
      return static_cast<double>(static_cast<std::int64_t>(random() >> 1) % range);
    };
    Vec3 p[4];
    for (Vec3& q : p) q = {coordinate(), coordinate(), coordinate()};
    if (i % 5 == 0) p[3] = p[1] + p[2] - p[0];
    if (i % 5 == 1) p[3] = p[1] + p[2] - p[0] + Vec3(0, 0, static_cast<double>(i % 3 - 1));
    const int side = whole_side_of_plane(p[0], p[1], p[2], p[3]);
    zeros += side == 0 ? 1 : 0;
    for (const int exponent : {0, -60, 250, 900, -350, -1000, -1074}) {
      Vec3 q[4];
      for (int k = 0; k < 4; ++k) {  // the axes at different scales, which keeps the sign
        const int e = i % 4 == 0 ? exponent / 3 : exponent;
        q[k] = {std::ldexp(p[k].x(), exponent), std::ldexp(p[k].y(), e), std::ldexp(p[k].z(), exponent)};
      }
      ASSERT_EQ(side_of_plane(q[0], q[1], q[2], q[3]), side) << i << ' ' << exponent;
      ASSERT_EQ(side_of_plane(q[1], q[0], q[2], q[3]), -side) << i << ' ' << exponent;
      ASSERT_EQ(side_of_plane(q[3], q[0], q[2], q[1]), side) << i << ' ' << exponent;
    }
    ASSERT_EQ(detail::exact_side_of_plane(p[0], p[1], p[2], p[3]), side) << i;
  }
  EXPECT_GT(zeros, 4000u);
}

TEST(SpacePredicates, AreExactWhereRoundingDecidesWrongly) {
  // A point a few units in the last place off the plane x + y = 2 z.
  const Vec3 a(12, 12, 12), b(24, 0, 12), c(24, 24, 24);
  for (int i = -20; i <= 20; ++i) {
    for (int j = -20; j <= 20; ++j) {
      const Vec3 p(0.5 + i * 0x1p-53, 0.5 + j * 0x1p-53, 0.5);
      const int expected = i + j < 0 ? 1 : i + j > 0 ? -1 : 0;
      EXPECT_EQ(side_of_plane(a, b, c, p), expected) << i << ' ' << j;
      EXPECT_EQ(side_of_plane(b, a, c, p), -expected) << i << ' ' << j;
      EXPECT_EQ(side_of_plane(p, a, c, b), expected) << i << ' ' << j;
    }
  }
}

TEST(SpacePredicates, MixTheSmallestNumbersWithTheLargest) {
  const double large = 1.7e308, small = 5e-324;
  const Vec3 a(-large, -large, 0), b(large, -large, 0), c(0, large, 0);
  EXPECT_EQ(side_of_plane(a, b, c, {small, small, small}), 1);
  EXPECT_EQ(side_of_plane(a, b, c, {large, small, -small}), -1);
  EXPECT_EQ(side_of_plane(a, b, c, {large, 17, 0}), 0);
  EXPECT_EQ(side_of_plane({0, 0, 0}, {small, 0, 0}, {0, small, 0}, {large, large, small}), 1);
  EXPECT_EQ(side_of_plane({0, 0, 0}, {small, 0, 0}, {0, large, small}, {large, large, small}), 0);
  EXPECT_EQ(side_of_plane({0, 0, 0}, {small, 0, 0}, {0, large, small}, {large, large, 0}), -1);
}

TEST(SpacePredicates, ProductsThatAreTooSmallDontAddUpToAWrongSign) {
  // In units of the smallest number the determinant is 0.6 - 0.4 - 0.4, which rounds to 1 - 0 - 0.
  const auto small = [](double x) { return std::ldexp(x, -537); };
  const Vec3 v(small(2.0 / 3), small(1), 0), w(small(0.4), 0, small(0.6));
  EXPECT_EQ(side_of_plane({0, 0, 0}, {1, 1, 1}, v, w), -1);
  EXPECT_EQ(side_of_plane({0, 0, 0}, {1, 1, 1}, w, v), 1);
}

TEST(SpacePredicates, TheBoundOfARoundedDeterminantHolds) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 50000; ++i) {
    const auto coordinate = [&] { return static_cast<double>(random() >> 27); };
    const Vec3 a(coordinate(), coordinate(), coordinate()), b(coordinate(), coordinate(), coordinate());
    const Vec3 c(coordinate(), coordinate(), coordinate());
    const auto part = [&] { return static_cast<double>(static_cast<int>(random() % 9) - 4); };
    // Close to the plane, where errors are largest against the value.
    const Vec3 d = a + (b - a) * part() + (c - a) * part() + Vec3(part(), part(), part());
    if (d.cwiseAbs().maxCoeff() >= 0x1p41) continue;
    const int sign = detail::rounded_determinant(a, b, c, d).sign();
    if (sign == 0) continue;
    EXPECT_EQ(sign, detail::exact_side_of_plane(a, b, c, d));
  }
}

}  // namespace
}  // namespace recede
