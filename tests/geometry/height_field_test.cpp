#include "sanitized.h"
#include <recede/geometry/height_field.h>

#include <gtest/gtest.h>

#include <random>

namespace recede {
namespace {

constexpr MapBorder k_borders[] = {MapBorder::clamped, MapBorder::periodic};

class Random {
 public:
  explicit Random(unsigned seed) : random_(seed) {}
  double number(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random_); }
  int index(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random_); }
  DisplacementMap map(int columns, int rows, double height, MapBorder border) {
    std::vector<float> heights;
    for (int i = 0; i < columns * rows; ++i) heights.push_back(static_cast<float>(number(0, height)));
    return {columns, rows, std::move(heights), border};
  }

 private:
  std::mt19937 random_;
};

TEST(HeightField, IsTheSurfaceOfTheMap) {
  // Rows: 0 1 / 2 4. Straight down at the middles of the texels, between them, and in the corners.
  for (const MapBorder border : k_borders) {
    const DisplacementMap map(2, 2, {0, 1, 2, 4}, border);
    const HeightField field(map);
    for (const double u : {0.0, .1, .25, .5, .6, .75, 1.0}) {
      for (const double v : {0.0, .1, .25, .5, .6, .75, 1.0}) {
        const auto hit = field.first_hit({u, v, 10}, {0, 0, -2});
        ASSERT_TRUE(hit) << u << ' ' << v;
        // A few roundings of numbers up to 10.
        EXPECT_NEAR(10 - 2 * hit->t, map.height_at({u, v}), 1e-14);
        EXPECT_LT((hit->uv - Vec2(u, v)).norm(), 1e-15);
        EXPECT_GT(hit->normal.z(), 0);
      }
    }
    EXPECT_FALSE(field.is_hit({1.001, .5, 10}, {0, 0, -1}));
    EXPECT_FALSE(field.is_hit({.5, .5, 10}, {0, 0, 1}));
    EXPECT_FALSE(field.is_hit({.5, .5, 10}, {0, 0, 0}));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(field.is_hit({.5, nan, 10}, {0, 0, -1}));
    EXPECT_FALSE(field.is_hit({.5, .5, 10}, {nan, 0, -1}));
  }
}

TEST(HeightField, HasTheNormalOfItsSlopes) {
  Random random(3);
  const DisplacementMap map = random.map(9, 6, 0.3, MapBorder::periodic);
  const HeightField field(map);
  for (int i = 0; i < 500; ++i) {
    const Vec3 origin(random.number(0, 1), random.number(0, 1), 2);
    const auto hit = field.first_hit(origin, {random.number(-.2, .2), random.number(-.2, .2), -1});
    if (!hit) continue;
    const Vec2 slope = map.derivative_at(hit->uv);
    EXPECT_LT((hit->normal - Vec3(-slope.x(), -slope.y(), 1).normalized()).norm(), 1e-11);
  }
}

TEST(HeightField, OfOneTexelIsAFlatSquare) {
  const DisplacementMap map(1, 1, {0.5F});
  const HeightField field(map);
  const auto hit = field.first_hit({-1, .5, 1}, {3, 0, -1});
  ASSERT_TRUE(hit);
  EXPECT_DOUBLE_EQ(hit->t, .5);
  EXPECT_EQ(hit->normal, Vec3(0, 0, 1));
  EXPECT_TRUE(field.is_hit({.3, .2, 0}, {0, 0, 1}));
  EXPECT_FALSE(field.is_hit({.3, .2, 0}, {0, 0, 1}, 0, .49));
  EXPECT_FALSE(field.is_hit({.3, .2, 0}, {0, 0, 1}, .51, 9));
  EXPECT_FALSE(field.is_hit({-1, .5, .6}, {1, 0, 0}));
}

std::optional<double> distance_by_brute_force(const HeightField& field, const DisplacementMap& map,
                                              const Vec3& origin, const Vec3& direction, double t_min,
                                              double t_max) {
  const PatchRay ray(origin, direction);
  std::optional<double> best;
  for (int y = 0; y <= map.rows(); ++y) {
    for (int x = 0; x <= map.columns(); ++x) {
      const auto hit = ray.nearest_hit(field.cell(x, y), t_min, t_max);
      if (hit && (!best || hit->t < *best)) best = hit->t;
    }
  }
  return best;
}

TEST(HeightField, IsMetWhereATestOfAllCellsMeetsIt) {
  Random random(5);
  int hits = 0, misses = 0;
  for (const auto& [columns, rows] :
       {std::pair(1, 1), std::pair(5, 3), std::pair(16, 16), std::pair(31, 12)}) {
    for (const MapBorder border : k_borders) {
      const DisplacementMap map = random.map(columns, rows, 0.4, border);
      const HeightField field(map);
      for (int i = 0; i < 3000; ++i) {
        const Vec3 origin(random.number(-1, 2), random.number(-1, 2), random.number(-.5, 1));
        Vec3 direction = Vec3(random.number(0, 1), random.number(0, 1), random.number(0, .4)) - origin;
        if (i % 5 < 3) direction[i % 5] = 0;
        if (i % 11 == 0) direction = -Vec3::UnitZ();
        const double t_min = i % 3 == 0 ? 0.4 : 0, t_max = i % 4 == 0 ? 1 : 1e9;
        const auto expected = distance_by_brute_force(field, map, origin, direction, t_min, t_max);
        const auto hit = field.first_hit(origin, direction, t_min, t_max);
        ASSERT_EQ(hit.has_value(), expected.has_value());
        EXPECT_EQ(field.is_hit(origin, direction, t_min, t_max), expected.has_value());
        ++(hit ? hits : misses);
        if (!hit) continue;
        EXPECT_EQ(hit->t, *expected);
        const Vec3 point = origin + hit->t * direction;
        // Some roundings of numbers up to 3; a grazing hit loses no more, since both lie on the ray.
        EXPECT_LT((point.head<2>() - hit->uv).norm(), 1e-13);
      }
    }
  }
  EXPECT_GT(hits, 5000);
  EXPECT_GT(misses, 3000);
}

TEST(HeightField, LetsNoRayThroughBetweenCells) {
  Random random(7);
  const int n_rays = test::k_sanitized ? 20'000 : 300'000;
  for (const MapBorder border : k_borders) {
    const DisplacementMap map = random.map(33, 20, 0.3, border);
    const HeightField field(map);
    for (const double distance : {1.0, 1e3, 1e5}) {
      int missed = 0;
      for (int i = 0; i < n_rays; ++i) {
        // A point on a line between cells, at a corner of them in every third case. The ray comes from above
        // and leaves below the field, within the square: it must meet it.
        Vec2 uv((random.index(33) + .5) / 33, 1 - (random.index(20) + .5) / 20);
        if (i % 3 > 0) uv[i % 3 - 1] = random.number(0.05, 0.95);
        const Vec3 target(uv.x(), uv.y(), map.height_at(uv));
        // Steep enough to stay in the square on its way through the heights.
        const Vec3 up(random.number(-.05, .05), random.number(-.05, .05), 1);
        const Vec3 origin = target + distance * up;
        const double length = random.number(0.1, 10);
        if (!field.is_hit(origin, length * (target - origin))) ++missed;
      }
      EXPECT_EQ(missed, 0) << "from " << distance;
    }
  }
}

}  // namespace
}  // namespace recede
