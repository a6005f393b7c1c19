#include <recede/shells/detail/prism.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <random>

namespace recede {
namespace {

using detail::has_one_orientation;
using detail::Prism;

Prism right_prism(double height) {
  return {{Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)},
          {Vec3(0, 0, height), Vec3(4, 0, height), Vec3(0, 4, height)}};
}

/// A prism whose top is the bottom turned by nearly half a turn: the Jacobian at height r is 16 times
/// (1 - 2 r)^2 + r^2 `rest`^2.
Prism turned_prism(double rest) {
  Prism prism = right_prism(1);
  prism.top = {Vec3(0, 0, 1), Vec3(-4, 4 * rest, 1), Vec3(-4 * rest, -4, 1)};
  return prism;
}

template <typename Move>
Prism moved(Prism prism, Move&& move) {
  for (Vec3& p : prism.bottom) p = move(p);
  for (Vec3& p : prism.top) p = move(p);
  return prism;
}

TEST(Prism, HasOneOrientationWhereTheTopLies) {
  EXPECT_TRUE(has_one_orientation(right_prism(1), false));
  EXPECT_FALSE(has_one_orientation(right_prism(1), true));
  EXPECT_FALSE(has_one_orientation(right_prism(-1), false));
  EXPECT_TRUE(has_one_orientation(right_prism(-1), true));
  for (const bool is_inward : {false, true}) EXPECT_FALSE(has_one_orientation(right_prism(0), is_inward));
}

TEST(Prism, OneStepThroughItsTriangleIsEnough) {
  for (std::size_t i = 0; i < 3; ++i) {
    Prism prism = right_prism(1);
    prism.top[i].z() = 0;  // no step out of the plane: 0 at that corner
    EXPECT_FALSE(has_one_orientation(prism, false)) << i;
    prism.top[i].z() = 5e-324;
    EXPECT_TRUE(has_one_orientation(prism, false)) << i;
  }
}

TEST(Prism, TheJacobianMayNotTouchZeroInTheMiddle) {
  EXPECT_FALSE(has_one_orientation(turned_prism(0), false));
  for (const double rest : {1e-3, 1e-9, 1e-17, 1e-160, 1e-300, 5e-324}) {
    EXPECT_TRUE(has_one_orientation(turned_prism(rest), false)) << rest;
    EXPECT_TRUE(has_one_orientation(turned_prism(-rest), false)) << rest;
    const auto mirrored = [](const Vec3& p) { return Vec3(p.x(), p.y(), -p.z()); };
    EXPECT_TRUE(has_one_orientation(moved(turned_prism(rest), mirrored), true)) << rest;
    EXPECT_FALSE(has_one_orientation(moved(turned_prism(rest), mirrored), false)) << rest;
  }
}

TEST(Prism, ScalesAndOffsetsDontMatter) {
  const std::vector<std::array<int, 3>> exponents = {{-30, -30, -30},       {30, 30, 30},
                                                     {-400, 300, 17},       {900, -900, 1},
                                                     {-1070, -1070, -1070}, {1000, 1000, 1000}};
  for (const std::array<int, 3>& exponent : exponents) {
    const int x = exponent[0];
    const auto scale = [&](const Vec3& p) {
      return Vec3(std::ldexp(p.x(), x), std::ldexp(p.y(), exponent[1]), std::ldexp(p.z(), exponent[2]));
    };
    EXPECT_TRUE(has_one_orientation(moved(right_prism(1), scale), false)) << x;
    EXPECT_FALSE(has_one_orientation(moved(right_prism(0), scale), false)) << x;
    EXPECT_FALSE(has_one_orientation(moved(turned_prism(0), scale), false)) << x;
    EXPECT_TRUE(has_one_orientation(moved(turned_prism(0.25), scale), false)) << x;
  }
  for (const double offset : {1e6, 0x1p49}) {
    const auto move = [&](const Vec3& p) { return Vec3(p + Vec3(offset, -offset, 3 * offset)); };
    EXPECT_TRUE(has_one_orientation(moved(right_prism(1), move), false)) << offset;
    EXPECT_FALSE(has_one_orientation(moved(turned_prism(0), move), false)) << offset;
    EXPECT_TRUE(has_one_orientation(moved(turned_prism(0.5), move), false)) << offset;
  }
}

/// The Jacobian at corner i and height k / n, times n^2; whole numbers.
std::int64_t whole_jacobian(const Prism& prism, std::size_t i, int k, int n) {
  const auto at = [&](std::size_t j) { return Vec3((n - k) * prism.bottom[j] + k * prism.top[j]); };
  const Vec3 u = at(1) - at(0), v = at(2) - at(0), w = prism.top[i] - prism.bottom[i];
  const auto whole = [](double x) { return static_cast<std::int64_t>(x); };
  const auto product = [&](int a, int b, int c) { return whole(u[a]) * whole(v[b]) * whole(w[c]); };
  return product(0, 1, 2) - product(1, 0, 2) + product(1, 2, 0) - product(2, 1, 0) + product(2, 0, 1) -
         product(0, 2, 1);
}

TEST(Prism, OfRandomWholePointsHasTheSignsOfAllSamples) {
  std::mt19937 random(1);
  constexpr int n = 48;  // a multiple of many denominators
  std::size_t n_good = 0, n_bad = 0, n_between = 0;
  for (int round = 0; round < 40000; ++round) {
    const unsigned size = round % 2 == 0 ? 3 : 100;
    const auto coordinate = [&] { return static_cast<double>(random() % (2 * size + 1)) - size; };
    Prism prism = right_prism(1);
    const double width = size;
    prism.bottom[1].x() = prism.bottom[2].y() = width;
    for (std::size_t i = 0; i < 3; ++i) {
      prism.top[i] = prism.bottom[i] + Vec3(coordinate(), coordinate(), std::abs(coordinate()));
    }
    std::int64_t least = 1;
    for (std::size_t i = 0; i < 3; ++i) {
      for (int k = 0; k <= n; ++k) least = std::min(least, whole_jacobian(prism, i, k, n));
    }
    const bool is_good = has_one_orientation(prism, false);
    const auto mirrored = [](const Vec3& p) { return Vec3(p.y(), p.x(), p.z()); };
    ASSERT_EQ(has_one_orientation(moved(prism, mirrored), true), is_good) << round;
    if (is_good) {
      ASSERT_GT(least, 0) << round;
    }
    (is_good ? n_good : n_bad) += 1;
    n_between += !is_good && least > 0 ? 1 : 0;  // below 0 between two samples only
  }
  EXPECT_GT(n_good, 2000u);
  EXPECT_GT(n_bad, 2000u);
  EXPECT_LT(n_between, n_bad / 200);
}

__extension__ using Wide = __int128;

Wide whole_determinant(const Vec3& u, const Vec3& v, const Vec3& w) {
  const auto product = [&](int a, int b, int c) {
    return Wide{static_cast<std::int64_t>(u[a])} * static_cast<std::int64_t>(v[b]) *
           static_cast<std::int64_t>(w[c]);
  };
  return product(0, 1, 2) - product(1, 0, 2) + product(1, 2, 0) - product(2, 1, 0) + product(2, 0, 1) -
         product(0, 2, 1);
}

TEST(Prism, WithAStepInItsPlaneIsInvertedWhateverRoundingSays) {
  // Whole coordinates below 2^38: determinants have more digits than a double.
  std::mt19937_64 random(2);
  std::size_t n_flat = 0, n_good = 0;
  for (int round = 0; round < 60000; ++round) {
    const auto coordinate = [&] { return static_cast<double>(random() >> 29) - 0x1p34; };
    const auto point = [&] { return Vec3(coordinate(), coordinate(), coordinate()); };
    Prism prism;
    for (Vec3& p : prism.bottom) p = point();
    const Vec3 b1 = prism.bottom[1] - prism.bottom[0], b2 = prism.bottom[2] - prism.bottom[0];
    for (std::size_t i = 0; i < 3; ++i) prism.top[i] = prism.bottom[i] + point();
    const auto part = [&] { return static_cast<double>(random() % 3) - 1; };
    prism.top[0] = prism.bottom[0] + part() * b1 + part() * b2 + (round % 2) * part() * Vec3(1, 2, 3);
    const Vec3 t1 = prism.top[1] - prism.top[0], t2 = prism.top[2] - prism.top[0];
    bool is_decided = true, is_flat = false;  // by the first corner's first coefficient alone
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 step = prism.top[i] - prism.bottom[i];
      const Wide first = whole_determinant(b1, b2, step), last = whole_determinant(t1, t2, step);
      const Wide middle = whole_determinant(b1, t2, step) + whole_determinant(t1, b2, step);
      if (i == 0) is_flat = first <= 0;
      is_decided = is_decided && middle > 0 && last > 0 && (i == 0 || first > 0);
    }
    if (!is_decided) continue;
    ASSERT_EQ(has_one_orientation(prism, false), !is_flat) << round;
    (is_flat ? n_flat : n_good) += 1;
  }
  EXPECT_GT(n_flat, 100u);
  EXPECT_GT(n_good, 20u);
}

}  // namespace
}  // namespace recede
