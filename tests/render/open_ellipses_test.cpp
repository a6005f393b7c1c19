#include "traced_plane.h"
#include <recede/geometry/error.h>
#include <recede/render/open_ellipses.h>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;

TEST(OpenEllipse, IsOneInsideAndNothingOnItsEdge) {
  // Turned by 30 degrees, radii 0.8 and 0.5.
  const double c = std::cos(k_pi / 6), s = std::sin(k_pi / 6);
  const OpenEllipse ellipse{
      {0.1, -0.2}, c * c * 0.64 + s * s * 0.25, c * s * (0.64 - 0.25), s * s * 0.64 + c * c * 0.25};
  EXPECT_NEAR(ellipse.inside({0.1, -0.2}), 1, 1e-15);
  EXPECT_NEAR(ellipse.inside(Vec2(0.1, -0.2) + 0.8 * Vec2(c, s)), 0, 1e-12);
  EXPECT_NEAR(ellipse.inside(Vec2(0.1, -0.2) + 0.5 * Vec2(-s, c)), 0, 1e-12);
  EXPECT_NEAR(ellipse.inside(Vec2(0.1, -0.2) + 1.6 * Vec2(c, s)), -3, 1e-12);
  const OpenEllipse::Axes axes = ellipse.axes();
  EXPECT_NEAR(std::abs(axes.major.dot(Vec2(c, s))), 1, 1e-12);
  EXPECT_NEAR(axes.radii.x(), 0.8, 1e-12);
  EXPECT_NEAR(axes.radii.y(), 0.5, 1e-12);
}

TEST(OpenEllipses, OfAFlatFieldAreUnitCircles) {
  const DisplacementMap map(2, 2, {1, 1, 1, 1}, MapBorder::periodic);
  const OpenEllipses ellipses = fit_open_ellipses(compute_visibility(DisplacedPlane(map, {1, 1})));
  for (const OpenEllipse& ellipse : ellipses.places) {
    EXPECT_EQ(ellipse.center, Vec2::Zero());
    EXPECT_EQ(ellipse.xx, 1);
    EXPECT_EQ(ellipse.xy, 0);
    EXPECT_EQ(ellipse.yy, 1);
  }
  // The soft edge ends 4.3 degrees above the horizon.
  EXPECT_EQ(ellipses.openness(0, test::direction_at(1.49, 2)), 1);
  EXPECT_EQ(ellipses.openness(0, Vec3(1, 0, 0)), 0);
  EXPECT_EQ(ellipses.openness(0, Vec3(0, 0.6, -0.8)), 0);
}

TEST(OpenEllipses, AtTheBottomOfATrenchHaveTheRadiiOfItsWalls) {
  // A narrow floor between walls of 45 degrees: radius 1 along it, 1 / sqrt(2) across.
  const DisplacementMap map = test::map_of(64, [](double u, double) {
    return std::min(0.25, std::max(0.0, std::abs(u - 0.5 / 64 - 0.5) - 0.02));
  });
  const HeightFieldVisibility visibility =
      compute_visibility(DisplacedPlane(map, {1, 1}), {.directions = 1000, .rows = 1});
  const OpenEllipse ellipse = fit_open_ellipses(visibility).places[32];
  ASSERT_NEAR(visibility.heights[32], 0, 1e-9);
  const OpenEllipse::Axes axes = ellipse.axes();
  // 1000 directions are 0.11 apart.
  EXPECT_NEAR(ellipse.center.norm(), 0, 0.03);
  EXPECT_NEAR(std::abs(axes.major.y()), 1, 1e-4);
  EXPECT_NEAR(axes.radii.x(), 1, 0.03);
  EXPECT_NEAR(axes.radii.y(), std::sqrt(0.5), 0.03);
}

TEST(OpenEllipses, AreNeverOpenAtTheBottomOfADeepHole) {
  std::vector<float> heights(100, 1000.0F);
  for (const std::size_t texel : {44U, 45U, 54U, 55U}) heights[texel] = 0;
  const DisplacementMap map(10, 10, heights, MapBorder::periodic);
  const HeightFieldVisibility visibility = compute_visibility(DisplacedPlane(map, {1, 1}));
  const std::size_t bottom = visibility.place(5, 5);
  ASSERT_NEAR(visibility.heights[bottom], 0, 1e-9);
  const OpenEllipses ellipses = fit_open_ellipses(visibility);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(ellipses.openness(bottom, test::direction_at(0.1 + 0.03 * i, i)), 0);
}

TEST(OpenEllipses, AreWrongAsRarelyAsTheNearestDirection) {
  // The source's method on the groove: known to be wrong for 9 % of all places and directions with 100
  // directions over the sphere, by the nearest direction as well. Directions below facets don't matter here,
  // and centre and axes move too.
  const DisplacementMap map = test::groove(32);
  const DisplacedPlane plane(map, {1, 1});
  const HeightFieldVisibility visibility = compute_visibility(plane, {.directions = 100, .rows = 1});
  const OpennessErrors all = measure_openness_errors(plane, visibility, fit_open_ellipses(visibility));
  EXPECT_LT(all.ellipses.mean, 0.05);
  EXPECT_LT(all.nearest.mean, 0.05);
  EXPECT_LT(all.three.mean, all.nearest.mean);
  EXPECT_LT(all.ellipses.worst, 0.12);
  const OpennessErrors radii =
      measure_openness_errors(plane, visibility, fit_open_ellipses(visibility, {.radii_only = true}));
  EXPECT_LT(radii.ellipses.mean, 0.09);
  EXPECT_GT(radii.ellipses.mean, all.ellipses.mean);

  const DisplacementMap waves = test::random_waves(1, 1.4);
  const DisplacedPlane wavy(waves, {8, 8});
  const HeightFieldVisibility of_waves = compute_visibility(wavy);
  const OpennessErrors errors = measure_openness_errors(wavy, of_waves, fit_open_ellipses(of_waves), 200);
  EXPECT_LT(errors.ellipses.mean, 0.09);
  EXPECT_GT(errors.ellipses.mean, 0.01) << "one ellipse can't have the outline of many crests";
}

TEST(OpenEllipses, FadeBetweenPlacesAndAcrossSeams) {
  const DisplacementMap map = test::random_waves(1, 1.4, 16);
  const HeightFieldVisibility visibility = compute_visibility(DisplacedPlane(map, {4, 4}));
  const OpenEllipses ellipses = fit_open_ellipses(visibility);
  const Vec3 light = test::direction_at(1.1, 0.5);
  for (std::size_t place = 0; place < visibility.place_count(); ++place)
    EXPECT_NEAR(ellipses.openness_at(visibility.uv(place), light), ellipses.openness(place, light), 1e-12);
  double largest = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vec2 uv(-0.5 + i / 2000.0, 0.3 + i / 7000.0);
    const double here = ellipses.openness_at(uv, light);
    EXPECT_NEAR(here, ellipses.openness_at(uv + Vec2(1, -2), light), 1e-9);
    largest = std::max(largest, std::abs(here - ellipses.openness_at(uv + Vec2(0.0005, 0), light)));
  }
  // From 0 to 1 it takes a cell, a sixteenth, at least; twice that with both axes.
  EXPECT_LT(largest, 0.0005 * 16 * 1.01);
  EXPECT_GT(largest, 0.001);
}

TEST(OpenEllipses, FollowTheCurvatureOfTheBase) {
  const DisplacementMap map = test::groove(32);
  const DisplacedPlane plane(map, {1, 1});
  const HeightFieldVisibility visibility = compute_visibility(plane, {.directions = 400, .rows = 1});
  const BendableEllipses bendable = fit_bendable_ellipses(visibility);
  // The mean over lights and places, where it isn't below the facet.
  const auto difference = [&](const OpenEllipses& a, const OpenEllipses& b) {
    double sum = 0;
    int count = 0;
    for (std::size_t place = 0; place < a.places.size(); ++place) {
      for (int i = 0; i < 100; ++i) {
        const Vec3 light = test::direction_at(0.015 * i, 2.4 * i);
        if (visibility.normals[place].dot(light) <= 0) continue;
        sum += std::abs(a.openness(place, light) - b.openness(place, light));
        ++count;
      }
    }
    return sum / count;
  };
  EXPECT_EQ(difference(bendable.bent({}), bendable.flat), 0);
  const auto refitted = [&](double curvature) {
    return fit_open_ellipses(visibility, {.curvature = {.along_u = curvature}});
  };
  for (const double curvature : {0.05, 0.1, 0.2})
    EXPECT_LT(difference(bendable.bent({.along_u = curvature}), refitted(curvature)), 0.02) << curvature;
  EXPECT_GT(difference(bendable.bent({.along_u = 3}), refitted(3)), 0.05) << "too far to be linear";
  // Light of a fixed elevation finds wider valleys on a bulge, narrower ones in a hollow.
  const auto open = [&](double curvature) {
    const OpenEllipses ellipses = bendable.bent({.along_u = curvature});
    double sum = 0;
    for (std::size_t i = 0; i < ellipses.places.size(); ++i)
      sum += ellipses.openness(i, test::direction_at(1.1, 0)) +
             ellipses.openness(i, test::direction_at(1.1, k_pi));
    return sum;
  };
  EXPECT_GT(open(0.2), open(0) + 0.1);
  EXPECT_LT(open(-0.2), open(0) - 0.1);
  EXPECT_THROW(fit_bendable_ellipses(visibility, {}, 0), OptionError);
}

TEST(OpenEllipses, AreTheSameForAnyNumberOfThreadsAndRefuseOptions) {
  const DisplacementMap map = test::random_waves(3, 1.4, 16);
  const HeightFieldVisibility visibility =
      compute_visibility(DisplacedPlane(map, {4, 4}), {.directions = 50});
  const auto with = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return fit_open_ellipses(visibility);
  };
  const OpenEllipses one = with(1), two = with(2);
  for (std::size_t i = 0; i < one.places.size(); ++i) {
    EXPECT_EQ(one.places[i].center, two.places[i].center);
    EXPECT_EQ(one.places[i].xx, two.places[i].xx);
    EXPECT_EQ(one.places[i].xy, two.places[i].xy);
    EXPECT_EQ(one.places[i].yy, two.places[i].yy);
  }
  EXPECT_THROW(fit_open_ellipses(visibility, {.soft_edge = -1}), OptionError);
  EXPECT_THROW(fit_open_ellipses(visibility, {.curvature = {std::nan(""), 0}}), OptionError);
  EXPECT_THROW(measure_openness_errors(DisplacedPlane(map, {4, 4}), visibility, one, 2), OptionError);
}

}  // namespace
}  // namespace recede
