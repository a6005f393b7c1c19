#include "displaced_planes.h"
#include <recede/geometry/bilinear_patch.h>
#include <recede/geometry/error.h>

#include <gtest/gtest.h>

#include <limits>

namespace recede {
namespace {

/// The nearest hit of all patches of all copies from -n to n.
std::optional<double> nearest_by_brute_force(const DisplacementMap& map, const Vec2& sides, int n,
                                             const Vec3& origin, const Vec3& direction) {
  const PatchRay ray(origin, direction);
  std::optional<double> nearest;
  const auto corner = [&](int x, int y) {
    const auto wrapped = [](int k, int count) { return (k % count + count) % count; };
    return Vec3((x + 0.5) / map.columns() * sides.x(), (1 - (y + 0.5) / map.rows()) * sides.y(),
                map.texel(wrapped(x, map.columns()), wrapped(y, map.rows())));
  };
  for (int y = -n * map.rows(); y < (n + 1) * map.rows(); ++y) {
    for (int x = -n * map.columns(); x < (n + 1) * map.columns(); ++x) {
      const auto hit =
          ray.nearest_hit({corner(x, y), corner(x + 1, y), corner(x, y + 1), corner(x + 1, y + 1)});
      if (hit && (!nearest || hit->t < *nearest)) nearest = hit->t;
    }
  }
  return nearest;
}

TEST(DisplacedPlane, IsMetWhereTheNearestOfAllPatchesOfAllCopiesIs) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(0, 1);
  std::vector<float> heights;
  for (int i = 0; i < 30; ++i) heights.push_back(static_cast<float>(number(random)));
  const DisplacementMap map(6, 5, heights, MapBorder::periodic);
  const Vec2 sides(3, 2);
  const DisplacedPlane plane(map, sides);
  int far_away = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 origin(3 * number(random), 2 * number(random), 1.2 * number(random));
    // Slopes of a tenth or more: at most twelve lengths within the heights. Six copies to each side have all.
    const Vec3 direction = test::turned({1, 0, (i % 2 ? -1 : 1) * (0.1 + number(random))},
                                        2 * std::numbers::pi * number(random));
    const auto hit = plane.first_hit(origin, direction);
    const auto expected = nearest_by_brute_force(map, sides, 6, origin, direction);
    ASSERT_EQ(hit.has_value(), expected.has_value()) << i;
    if (!hit) continue;
    // Roundings of places of up to ten.
    EXPECT_NEAR(hit->t, *expected, 1e-12) << i;
    const Vec3 place = origin + hit->t * direction;
    EXPECT_NEAR(map.height_at(Vec2(place.x() / 3, place.y() / 2)), place.z(), 1e-12);
    EXPECT_LT((plane.normal_at(hit->uv) - hit->normal).norm(), 1e-10);
    if (std::abs(place.x() - 1.5) > 1.5 || std::abs(place.y() - 1) > 1) ++far_away;
  }
  EXPECT_GT(far_away, 30) << "hits in other copies were to be tested";
}

TEST(DisplacedPlane, HasSlopesInTheUnitsOfItsSides) {
  // Heights 0 and 3 in turn, 2 apart along x: slopes of 3/2.
  const DisplacementMap map(2, 1, {0, 3}, MapBorder::periodic);
  const DisplacedPlane plane(map, {4, 9});
  const auto hit = plane.first_hit({2, 5, 10}, {0, 0, -1});
  ASSERT_TRUE(hit);
  EXPECT_DOUBLE_EQ(hit->t, 8.5);
  EXPECT_LT((hit->normal - Vec3(-1.5, 0, 1).normalized()).norm(), 1e-15);
  EXPECT_LT((plane.normal_at({0.5, 0.5}) - Vec3(-1.5, 0, 1).normalized()).norm(), 1e-15);
}

TEST(DisplacedPlane, IsMetByEveryRayFromAboveAtAnyAngle) {
  const DisplacementMap map = test::random_waves(2, 0.1);
  const DisplacedPlane plane(map, {1, 1});
  // At 89.99 degrees a ray passes over up to a thousand copies.
  for (const double degrees : {0.0, 45.0, 80.0, 89.0, 89.99}) {
    int met = 0;
    const int count = degrees > 89.5 ? 100 : 2000;
    test::for_seen_normals(plane, degrees * std::numbers::pi / 180, count,
                           [&](const Vec3&, double, const DisplacedPlane::Hit&) { ++met; });
    EXPECT_EQ(met, count) << degrees;
  }
}

TEST(DisplacedPlane, IsMetAlongTheLinesBetweenCopies) {
  const DisplacementMap map = test::random_waves(3, 0.2, 8);
  const DisplacedPlane plane(map, {1, 1});
  for (const Vec3& direction : {Vec3(1, 0, -0.1), Vec3(-1, 0, -0.1), Vec3(0, 1, -0.1), Vec3(0, -1, -0.1),
                                Vec3(1, 1, -0.1), Vec3(-1, 1, -0.1), Vec3(0, 0, -1)}) {
    for (int k = -2; k <= 2; ++k)
      EXPECT_TRUE(plane.first_hit({1.0 * k, 2.0 * k, 0.5}, direction)) << direction.transpose() << ' ' << k;
  }
}

TEST(DisplacedPlane, MeetsNoRaysThatLeadNowhere) {
  const DisplacementMap map(2, 2, {0, 1, 1, 0}, MapBorder::periodic);
  const DisplacedPlane plane(map, {1, 1});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(plane.first_hit({0, 0, 2}, {0, 0, 1}));
  EXPECT_FALSE(plane.first_hit({0, 0, 2}, {1, 0, 0}));
  EXPECT_FALSE(plane.first_hit({0, 0, 2}, {0, 0, 0}));
  EXPECT_FALSE(plane.first_hit({0, nan, 2}, {0, 0, -1}));
  EXPECT_FALSE(plane.first_hit({0, 0, 2}, {0, nan, -1}));
  EXPECT_TRUE(plane.first_hit({0, 0, 0.5}, {1, 0, 0}));
  EXPECT_FALSE(plane.first_hit({0, 0, 1.00001}, {1, 0.3, 0}));
}

TEST(DisplacedPlane, RefusesMapsWhoseCopiesDontFitAndSidesThatArentLengths) {
  const DisplacementMap clamped(2, 2, {0, 1, 1, 0});
  EXPECT_THROW(DisplacedPlane(clamped, {1, 1}), InputError);
  const DisplacementMap map(2, 2, {0, 1, 1, 0}, MapBorder::periodic);
  for (const double side :
       {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(DisplacedPlane(map, {side, 1}), OptionError) << side;
    EXPECT_THROW(DisplacedPlane(map, {1, side}), OptionError) << side;
  }
}

}  // namespace
}  // namespace recede
