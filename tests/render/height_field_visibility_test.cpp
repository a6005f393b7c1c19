#include "traced_plane.h"
#include <recede/geometry/error.h>
#include <recede/render/diffuse_scattering.h>
#include <recede/render/height_field_visibility.h>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <limits>
#include <numeric>

namespace recede {
namespace {

TEST(HeightFieldVisibility, OfAFlatFieldIsNothingAboveAndBelowUnderneath) {
  const DisplacementMap map(4, 3, std::vector<float>(12, 7.0F), MapBorder::periodic);
  const HeightFieldVisibility visibility = compute_visibility(DisplacedPlane(map, {1, 1}));
  EXPECT_EQ(visibility.columns, 4);
  EXPECT_EQ(visibility.rows, 3);
  ASSERT_EQ(visibility.seen.size(), 12U * 128U);
  for (std::size_t direction = 0; direction < 128; ++direction) {
    const std::uint16_t expected = direction < 64 ? SeenPlace::k_nothing : SeenPlace::k_below;
    for (std::size_t place = 0; place < 12; ++place)
      EXPECT_EQ(visibility.seen_from(place, direction).column, expected);
  }
  EXPECT_EQ(visibility.bytes(), 12U * 128U * 8U);
}

TEST(HeightFieldVisibility, OfTwoFacetsIsTheOther) {
  // Slopes of 1 and -1 in turn: all that isn't sky is the other facet, with its middle as its place.
  const DisplacementMap map(2, 1, {0, 1}, MapBorder::periodic);
  const DisplacedPlane plane(map, {2, 1});
  const HeightFieldVisibility visibility = compute_visibility(plane, {.directions = 300});
  int places = 0;
  for (std::size_t i = 0; i < visibility.sphere.size(); ++i) {
    for (const std::size_t place : {std::size_t{0}, std::size_t{1}}) {
      const SeenPlace& seen = visibility.seen_from(place, i);
      const Vec3& d = visibility.sphere.directions[i];
      if (!seen.is_place()) {
        EXPECT_EQ(visibility.distance_from(place, i), 0);
        // From the middle of a facet, at half of the height, the other crest is 1.5 away and 0.5 higher.
        EXPECT_TRUE(!seen.is_nothing() || d.z() >= std::abs(d.x()) / 3 - 1e-9);
        continue;
      }
      ++places;
      EXPECT_EQ(visibility.place(seen), 1 - place);
      const double x =
          visibility.uv(place).x() * 2 + d.x() * static_cast<double>(visibility.distance_from(place, i));
      const double z = 0.5 + d.z() * static_cast<double>(visibility.distance_from(place, i));
      EXPECT_NEAR(map.height_at({x / 2, 0.5}), z, 1e-5) << "distances are floats";
    }
  }
  EXPECT_GT(places, 60);
}

TEST(HeightFieldVisibility, HasTheHitsOfRaysOneByOneAcrossSeams) {
  const DisplacementMap map = test::rough_ground(4, 1.3, 9);
  const DisplacedPlane plane(map, {9, 7});
  const HeightFieldVisibility visibility = compute_visibility(plane, {.directions = 40});
  int hits = 0, in_other_copies = 0;
  for (std::size_t place = 0; place < visibility.place_count(); ++place) {
    const Vec2 at = visibility.uv(place).cwiseProduct(Vec2(9, 7));
    for (std::size_t i = 0; i < 40; ++i) {
      const Vec3& d = visibility.sphere.directions[i];
      const SeenPlace& seen = visibility.seen_from(place, i);
      if (visibility.normals[place].dot(d) <= 0) {
        EXPECT_EQ(seen.column, SeenPlace::k_below);
        continue;
      }
      // From another copy of the map, and started a little differently.
      const Vec3 start(at.x() + 18, at.y() - 7, map.height_at(visibility.uv(place)) + 1e-7);
      const auto hit = plane.first_hit(start, d);
      ASSERT_EQ(hit.has_value(), seen.is_place()) << place << ' ' << i;
      EXPECT_EQ(is_open(plane, visibility, place, d), !hit);
      if (!hit) continue;
      ++hits;
      // Starts are a millionth apart, and a ray along a facet makes hundreds of that.
      EXPECT_NEAR(hit->t, visibility.distance_from(place, i), 1e-3);
      const Vec2 off = hit->uv - visibility.uv(visibility.place(seen));
      EXPECT_LE(std::abs(off.x() - std::round(off.x())), 0.5 / 9 + 1e-5);
      EXPECT_LE(std::abs(off.y() - std::round(off.y())), 0.5 / 9 + 1e-5);
      const Vec3 end = start - Vec3(18, -7, 0) + hit->t * d;
      in_other_copies += end.x() < 0 || end.x() > 9 || end.y() < 0 || end.y() > 7;
    }
  }
  EXPECT_GT(hits, 300);
  EXPECT_GT(in_other_copies, 50);
}

TEST(HeightFieldVisibility, StaysTheSameWhenTheMapIsShifted) {
  // Whole texels to the side: what was at the seam comes to the middle.
  const auto heights = [](double u, double v, double shift) {
    return 0.1 * std::sin(2 * std::numbers::pi * (u + shift)) * std::cos(4 * std::numbers::pi * v);
  };
  const DisplacementMap map = test::map_of(16, [&](double u, double v) { return heights(u, v, 0); });
  const DisplacementMap shifted = test::map_of(16, [&](double u, double v) { return heights(u, v, 0.25); });
  const DisplacedPlane plane(map, {1, 1}), moved(shifted, {1, 1});
  const HeightFieldVisibility a = compute_visibility(plane), b = compute_visibility(moved);
  const DiffuseTransport from_a(a), from_b(b);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; ++x) {
      // Heights are floats, so a ray in a thousand may land on the other side of a line.
      EXPECT_NEAR(from_a.sky()[a.place((x + 4) % 16, y)], from_b.sky()[b.place(x, y)], 0.01);
    }
  }
}

TEST(HeightFieldVisibility, IsTheSameForAnyNumberOfThreads) {
  const DisplacementMap map = test::random_waves(3, 1.4, 16);
  const DisplacedPlane plane(map, {4, 4});
  const auto with = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return compute_visibility(plane, {.directions = 50, .columns = 20, .rows = 12});
  };
  const HeightFieldVisibility one = with(1), two = with(2);
  EXPECT_EQ(one.seen, two.seen);
  EXPECT_EQ(one.distances, two.distances);
}

TEST(HeightFieldVisibility, TellsShadowsAsWellAsItsDirectionsAllow) {
  const DisplacementMap map = test::random_waves(1, 1.4);
  const DisplacedPlane plane(map, {8, 8});
  double wrong_before = 1;
  for (const int count : {40, 400}) {
    const HeightFieldVisibility visibility = compute_visibility(plane, {.directions = count});
    int wrong_nearest = 0, wrong_three = 0, all = 0;
    for (std::size_t place = 0; place < visibility.place_count(); place += 7) {
      for (int i = 0; i < 40; ++i) {
        const Vec3 light = test::direction_at(0.04 * i, 2.4 * i);
        const bool open = is_open(plane, visibility, place, light);
        const double three = openness_by_three(visibility, place, light);
        EXPECT_GE(three, 0);
        EXPECT_LE(three, 1);
        wrong_nearest += is_open_by_nearest(visibility, place, light) != open;
        wrong_three += (three >= 0.5) != open;
        ++all;
      }
    }
    EXPECT_LT(wrong_three, count < 100 ? all / 6 : wrong_nearest);
    // Ten times as many directions are three times as dense.
    EXPECT_LT(static_cast<double>(wrong_nearest) / all, wrong_before / 2);
    wrong_before = static_cast<double>(wrong_nearest) / all;
  }
  EXPECT_LT(wrong_before, 0.05);
}

TEST(HeightFieldVisibility, HoldsAtASpikeAtCliffsAndForOneTexel) {
  std::vector<float> spike(64, 0.0F);
  spike[20] = 50;
  const DisplacementMap map(8, 8, spike, MapBorder::periodic);
  const HeightFieldVisibility visibility =
      compute_visibility(DisplacedPlane(map, {8, 8}), {.directions = 60});
  // Slopes of up to 50: 89 degrees. What is seen is in front of the place, and the sky closes the rest.
  for (std::size_t place = 0; place < 64; ++place) {
    for (std::size_t i = 0; i < 60; ++i) {
      const SeenPlace& seen = visibility.seen_from(place, i);
      EXPECT_EQ(visibility.distance_from(place, i) > 0, seen.is_place());
      EXPECT_TRUE(!seen.is_nothing() || visibility.sphere.directions[i].z() > 0)
          << "downwards there is ground";
    }
  }
  const DiffuseTransport transport(visibility);
  for (const double sky : transport.sky()) {
    EXPECT_GE(sky, 0);
    EXPECT_LE(sky, 1);
  }
  const DisplacementMap one(1, 1, {3}, MapBorder::periodic);
  EXPECT_EQ(compute_visibility(DisplacedPlane(one, {1, 1})).place_count(), 1U);
}

TEST(HeightFieldVisibility, RefusesWhatItCantDo) {
  const DisplacementMap map = test::rough_ground(1, 1, 4);
  const DisplacedPlane plane(map, {1, 1});
  EXPECT_THROW(compute_visibility(plane, {.directions = 0}), OptionError);
  EXPECT_THROW(compute_visibility(plane, {.columns = -1}), OptionError);
  EXPECT_THROW(compute_visibility(plane, {.rows = 40'000}), OptionError);
  EXPECT_THROW(compute_visibility(plane, {.columns = 32'000, .rows = 32'000}), OptionError);
  const DisplacementMap clamped(2, 2, {0, 1, 2, 3});
  EXPECT_THROW(DisplacedPlane(clamped, {1, 1}), InputError);
  const std::vector<float> not_a_number(1, std::numeric_limits<float>::quiet_NaN());
  EXPECT_THROW(DisplacementMap(1, 1, not_a_number, MapBorder::periodic), InputError);
}

/// Share of the light of an even sky that comes from other places, the mean over all.
double hit_share(const HeightFieldVisibility& visibility, const BaseCurvature& curvature = {}) {
  const DiffuseTransport transport(visibility, curvature);
  const std::vector<double>& sky = transport.sky();
  return 1 - std::accumulate(sky.begin(), sky.end(), 0.0) / static_cast<double>(sky.size());
}

TEST(CurvedVisibility, OpensTheGrooveOnABulgeAndClosesItInAHollow) {
  const DisplacementMap map = test::groove(32);
  const DisplacedPlane plane(map, {1, 1});
  const HeightFieldVisibility coarse = compute_visibility(plane, {.directions = 100, .rows = 1});
  const HeightFieldVisibility fine = compute_visibility(plane, {.directions = 1600, .rows = 1});
  // Flat: 1 - sin(45 degrees). Curvature times period, and the exact share with circles instead of lines.
  EXPECT_NEAR(hit_share(coarse), 0.2929, 0.003);
  EXPECT_NEAR(hit_share(fine), 0.2929, 0.001);
  const std::pair<double, double> cases[] = {{0.1, 0.268}, {0.2, 0.244}, {-0.1, 0.319}, {-0.2, 0.346}};
  for (const auto& [curvature, exact] : cases) {
    const double change = exact - 0.2929;
    // Directions at the edge of the sky stand for both sides of it: with 100 of them, a third of the change
    // is lost, with 1600 a ninth.
    EXPECT_NEAR(hit_share(coarse, {.along_u = curvature}) - hit_share(coarse), change,
                0.33 * std::abs(change));
    EXPECT_NEAR(hit_share(fine, {.along_u = curvature}) - hit_share(fine), change, 0.14 * std::abs(change));
  }
  // Along the groove, curvature changes nothing but what ends of it see.
  EXPECT_NEAR(hit_share(fine, {.along_v = 0.1}), 0.2929, 0.012);
}

TEST(CurvedVisibility, LeavesAFlatBaseAsItIs) {
  const DisplacementMap map = test::rough_ground(2, 1, 6);
  const HeightFieldVisibility visibility = compute_visibility(DisplacedPlane(map, {6, 6}));
  const BentDirections bent = bend_directions(visibility, 3, {});
  EXPECT_EQ(bent.directions, visibility.sphere.directions);
  const std::vector<double> ones(128, 1.0);
  EXPECT_EQ(bent.weights, ones);
  const BentDirections nearly = bend_directions(visibility, 3, {1e-9, -1e-9});
  for (std::size_t i = 0; i < 128; ++i) {
    EXPECT_LT((nearly.directions[i] - bent.directions[i]).norm(), 1e-7);
    EXPECT_NEAR(nearly.weights[i], 1, 1e-6);
  }
  EXPECT_THROW(bend_directions(visibility, 0, {std::nan(""), 0}), OptionError);
}

}  // namespace
}  // namespace recede
