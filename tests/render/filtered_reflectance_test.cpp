#include "displaced_planes.h"
#include "sanitized.h"
#include <recede/render/filtered_reflectance.h>

#include <gtest/gtest.h>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;
constexpr double k_degree = k_pi / 180;

FacetDistribution facets_with_slopes(std::initializer_list<FacetGroup> groups) {
  return merge_facets(std::vector<FacetGroup>(groups));
}

/// Half of the facets rise by 45 degrees along x, half fall.
FacetDistribution groove() {
  return facets_with_slopes({{.share = 0.5, .slope = {1, 0}}, {.share = 0.5, .slope = {-1, 0}}});
}

Vec3 random_direction(std::mt19937& random, double least_height) {
  std::uniform_real_distribution<double> number(0, 1);
  const double height = least_height + (1 - least_height) * number(random);
  return test::direction_at(std::acos(height), 2 * k_pi * number(random));
}

/// A facet's own reflectance, from the definitions.
double facet_reflectance(const Vec3& normal, const Vec3& v, const Vec3& l, const FacetMaterial& material) {
  const double cos_v = normal.dot(v), cos_l = normal.dot(l);
  if (cos_v <= 0 || cos_l <= 0) return 0;
  const Vec3 half = (v + l).normalized();
  const double alpha_squared = material.roughness * material.roughness, cos_half = normal.dot(half);
  const double d = alpha_squared / (k_pi * std::pow(cos_half * cos_half * (alpha_squared - 1) + 1, 2));
  const auto lambda = [&](double cosine) {
    return (std::sqrt(1 + alpha_squared * (1 / (cosine * cosine) - 1)) - 1) / 2;
  };
  const double fresnel =
      material.normal_reflectance + (1 - material.normal_reflectance) * std::pow(1 - half.dot(v), 5);
  return material.albedo / k_pi + material.reflection * d * fresnel /
                                      ((1 + lambda(cos_v)) * (1 + lambda(cos_l))) / (4 * cos_v * cos_l);
}

std::vector<FacetDistribution> many_distributions() {
  std::vector<FacetDistribution> all{groove(), facets_with_slopes({{.share = 1, .slope = {0.3, -0.2}}}),
                                     facets_with_slopes({{.share = 1, .slope = {0, 0}, .spread = 0.5}})};
  for (const double peak : {0.7, 3.0, 20.0})
    all.push_back(PackedFacets(facets_of(test::random_waves(5, peak), {.sides = {32, 32}})).unpacked());
  // A tilted piece of a surface.
  FacetDistribution tilted = all.back();
  for (FacetGroup& group : tilted.stored) group.slope += Vec2(0.8, 0.1);
  all.push_back(tilted);
  return all;
}

TEST(FilteredReflectance, OfOneFacetIsTheFacetsOwn) {
  std::mt19937 random(1);
  for (const Vec2& slope : {Vec2(0, 0), Vec2(0.5, -0.3), Vec2(-3, 1)}) {
    const FacetDistribution facet = facets_with_slopes({{.share = 1, .slope = slope}});
    const Vec3 normal = Vec3(-slope.x(), -slope.y(), 1).normalized();
    for (const double roughness : {0.05, 0.2, 1.0}) {
      const FacetMaterial material{.albedo = 0.3, .roughness = roughness};
      for (int i = 0; i < 200; ++i) {
        const Vec3 v = random_direction(random, 0), l = random_direction(random, 0);
        const double expected = facet_reflectance(normal, v, l, material);
        EXPECT_NEAR(filtered_reflectance(facet, v, l, material), expected, 1e-9 * (1 + expected));
      }
    }
  }
}

TEST(FilteredReflectance, OfAGrooveSeenFromAboveIsThatOfItsLitSides) {
  // Light from 60 degrees beside falls on one side alone, and on its upper part, for the crest before it
  // shades the rest. All light that arrives at the plane arrives at this side, which is half of what is seen,
  // on 0.5 sqrt(2) of area for 1 of the plane: the reflectance is albedo / pi / sqrt(2).
  const FacetMaterial matt{.albedo = 0.8, .reflection = 0};
  const Vec3 light = test::direction_at(60 * k_degree, 0);
  EXPECT_NEAR(filtered_reflectance(groove(), Vec3::UnitZ(), light, matt), 0.8 / k_pi / std::sqrt(2), 1e-12);
  // From 30 degrees it falls on both sides, by 15 and 75 degrees, and nothing is shaded.
  const double both = (std::cos(15 * k_degree) + std::cos(75 * k_degree)) / 2 / std::cos(30 * k_degree);
  EXPECT_NEAR(filtered_reflectance(groove(), Vec3::UnitZ(), test::direction_at(30 * k_degree, 0), matt),
              0.8 / k_pi * both, 1e-12);
}

TEST(FilteredReflectance, OfAGrooveTakesWhatIsHiddenAndShadedToDependOnHeightsAlike) {
  // Both from 60 degrees on the same side. The side that they see has the cosine 0.966 and half of the
  // shares; the plane shows 0.5, so (0.866 + 0.5) / 2 is 1.366 times too much for either, together 1.732.
  const Vec3 beside = test::direction_at(60 * k_degree, 0);
  const double to_side = std::sin(60 * k_degree) + 0.5;
  const double expected = 0.5 * to_side * to_side / std::sqrt(2) / (0.5 * 0.5 * (2 * to_side - 1)) / k_pi;
  EXPECT_NEAR(filtered_reflectance(groove(), beside, beside, {.albedo = 1, .reflection = 0}), expected,
              1e-12);
  // From opposite sides none is both seen and lit.
  const Vec3 opposite = test::direction_at(60 * k_degree, k_pi);
  EXPECT_EQ(filtered_reflectance(groove(), beside, opposite, {.albedo = 1, .reflection = 0}), 0);
}

TEST(FilteredReflectance, IsExactlyTheSameWhenLightAndViewerChangePlaces) {
  std::mt19937 random(2);
  for (const FacetDistribution& facets : many_distributions()) {
    for (int i = 0; i < 500; ++i) {
      const Vec3 v = random_direction(random, 0), l = random_direction(random, 0);
      const FacetMaterial material{.albedo = 0.5, .roughness = 0.1};
      ASSERT_EQ(filtered_reflectance(facets, v, l, material), filtered_reflectance(facets, l, v, material));
    }
  }
}

TEST(FilteredReflectance, SendsNoMoreLightThanArrives) {
  const FacetMaterial materials[] = {{.albedo = 1, .reflection = 0},
                                     {.albedo = 0, .roughness = 0.5, .normal_reflectance = 1},
                                     {.albedo = 0, .roughness = 0.2, .normal_reflectance = 1}};
  for (const FacetDistribution& facets : many_distributions()) {
    const Vec3 normal = Vec3(-facets.mean_slope().x(), -facets.mean_slope().y(), 1).normalized();
    for (const FacetMaterial& material : materials) {
      for (const double degrees : {0.0, 40.0, 75.0, 88.0}) {
        const Vec3 viewer = test::direction_at(degrees * k_degree, 0.5);
        // Over the whole sphere: directions below the plane have 0.
        constexpr int k_rows = 256, k_columns = 256;
        double sum = 0;
        for (int i = 0; i < k_rows * k_columns; ++i) {
          const double height = 2 * (i / k_columns + 0.5) / k_rows - 1;
          const Vec3 light =
              test::direction_at(std::acos(height), 2 * k_pi * (i % k_columns + 0.5) / k_columns);
          sum += filtered_reflectance(facets, viewer, light, material) * std::max(0.0, normal.dot(light));
        }
        // The rule's error, for lobes of 0.2 that some dozens of cells cover.
        EXPECT_LE(sum * 4 * k_pi / (k_rows * k_columns), 1.002) << degrees << ' ' << material.roughness;
      }
    }
  }
}

TEST(FilteredReflectance, OfAWhiteFlatPlaneSendsAllLightBack) {
  const FacetDistribution flat = facets_with_slopes({{.share = 1}});
  EXPECT_DOUBLE_EQ(
      filtered_reflectance(flat, Vec3::UnitZ(), Vec3(0.6, 0, 0.8), {.albedo = 1, .reflection = 0}), 1 / k_pi);
}

TEST(FilteredReflectance, IsNothingBelowThePlane) {
  EXPECT_EQ(filtered_reflectance(groove(), Vec3(0.8, 0, -0.6), Vec3::UnitZ()), 0);
  EXPECT_EQ(filtered_reflectance(groove(), Vec3::UnitZ(), Vec3(1, 0, 0)), 0);
  const FacetDistribution tilted = facets_with_slopes({{.share = 1, .slope = {2, 0}}});
  EXPECT_EQ(filtered_reflectance(tilted, Vec3::UnitZ(), Vec3(0.8, 0, 0.6)), 0) << "behind the slope";
}

TEST(FilteredReflectance, OfFourteenGroupsIsAboutThatOfAllFacets) {
  // A cloud of slopes that no group has alone. Without spreads, lobes of 0.1 stand apart.
  std::mt19937 random(3);
  std::normal_distribution<double> slope(0, 0.35);
  std::vector<FacetGroup> cloud;
  for (int i = 0; i < 3000; ++i) cloud.push_back({.share = 1, .slope = Vec2(slope(random), slope(random))});
  const FacetDistribution few = PackedFacets(merge_facets(cloud)).unpacked();
  FacetDistribution without_spreads = few;
  for (FacetGroup& group : without_spreads.stored) group.spread = 0;
  const FacetMaterial glossy{.albedo = 0, .roughness = 0.1};
  double sum = 0, error = 0, error_without = 0;
  for (int pair = 0; pair < 100; ++pair) {
    const Vec3 v = random_direction(random, 0.5), l = random_direction(random, 0.5);
    // Of all facets, with the same rule for what is hidden.
    double scattered = 0, area_v = 0, area_l = 0;
    for (const FacetGroup& facet : cloud) {
      const Vec3 n(-facet.slope.x(), -facet.slope.y(), 1);
      area_v += std::max(0.0, n.dot(v)) / 3000;
      area_l += std::max(0.0, n.dot(l)) / 3000;
      scattered += std::max(0.0, n.dot(v)) * std::max(0.0, n.dot(l)) / n.norm() *
                   facet_reflectance(n.normalized(), v, l, glossy) / 3000;
    }
    const double all = scattered / (v.z() * l.z() * (area_v / v.z() + area_l / l.z() - 1));
    sum += all;
    error += std::abs(filtered_reflectance(few, v, l, glossy) - all);
    error_without += std::abs(filtered_reflectance(without_spreads, v, l, glossy) - all);
  }
  // Measured: 9 % for the page's Gaussian bumps, where chance and hidden parts count too.
  EXPECT_LT(error, 0.1 * sum);
  EXPECT_GT(error_without, 3 * error);
}

TEST(FilteredReflectance, IsThatOfTheDisplacedSurfaceByRays) {
  if (test::k_sanitized) GTEST_SKIP() << "a million rays, and no other code than in the rest";
  const DisplacementMap map = test::random_waves(1, 1.4);
  const DisplacedPlane plane(map, {32, 32});
  const FacetDistribution facets = PackedFacets(facets_of(map, {.sides = {32, 32}})).unpacked();
  std::mt19937 random(4);
  double sum = 0, error = 0;
  for (int pair = 0; pair < 100; ++pair) {
    const Vec3 v = random_direction(random, std::cos(75 * k_degree));
    const Vec3 l = random_direction(random, std::cos(75 * k_degree));
    double traced = 0;
    constexpr int k_rays = 4096;
    test::for_places(plane, k_rays, [&](const Vec2& place, double) {
      const Vec3 start = Vec3(place.x(), place.y(), plane.heights().max) + 1e-6 * v;
      const auto hit = plane.first_hit(start, -v);
      if (!hit || hit->normal.dot(l) <= 0) return;
      if (plane.first_hit(start - hit->t * v + 1e-6 * hit->normal, l)) return;
      traced += facet_reflectance(hit->normal, v, l, {}) * hit->normal.dot(l) / k_rays;
    });
    sum += traced;
    error += std::abs(filtered_reflectance(facets, v, l) * l.z() - traced);
  }
  // The claim is 2.5 %. Rays err by about half a per cent, and which facets are hidden isn't chance on waves.
  EXPECT_LT(error, 0.025 * sum);
}

}  // namespace
}  // namespace recede
