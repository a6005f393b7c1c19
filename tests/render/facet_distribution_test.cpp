#include "cancelling.h"
#include "displaced_planes.h"
#include <recede/geometry/error.h>
#include <recede/render/facet_distribution.h>

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <limits>

namespace recede {
namespace {

/// Slopes of 0.5 and -0.5 in turn along u, of equal widths.
DisplacementMap ridges() { return {2, 1, {0, 1}, MapBorder::periodic}; }
constexpr double k_ridge_side = 4;

double sum_of_shares(const FacetDistribution& facets) {
  double sum = 0;
  for (const FacetGroup& group : facets.groups()) sum += group.share;
  return sum;
}

/// Mean of the squares of slopes.
double mean_square(std::span<const FacetGroup> groups) {
  double sum = 0, shares = 0;
  for (const FacetGroup& group : groups) {
    sum += group.share * (group.slope.squaredNorm() + 2 * group.spread * group.spread);
    shares += group.share;
  }
  return sum / shares;
}

/// Area of the facets that look to a direction, as it sees it.
double area_toward(const FacetDistribution& facets, const Vec3& direction) {
  double sum = 0;
  for (const FacetGroup& group : facets.groups())
    sum += group.share * std::max(0.0, direction.z() - direction.head<2>().dot(group.slope));
  return sum;
}

std::vector<FacetGroup> random_groups(unsigned seed, int count, double steepness) {
  std::mt19937 random(seed);
  std::normal_distribution<double> slope(0, steepness);
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<FacetGroup> groups;
  for (int i = 0; i < count; ++i) {
    FacetGroup group{.share = share(random), .spread = i % 3 == 0 ? 0.1 * share(random) : 0.0};
    group.slope.x() = slope(random);
    group.slope.y() = slope(random);
    groups.push_back(group);
  }
  return groups;
}

TEST(FacetDistribution, OfAFlatMapIsOneFacet) {
  for (const MapBorder border : {MapBorder::clamped, MapBorder::periodic}) {
    for (const int size : {1, 2, 7}) {
      const DisplacementMap map(
          size, size,
          std::vector<float>(static_cast<std::size_t>(size) * static_cast<std::size_t>(size), 3.0f), border);
      const FacetDistribution facets = PackedFacets(facets_of(map)).unpacked();
      ASSERT_EQ(facets.count, 1u);
      EXPECT_EQ(facets.stored[0].share, 1);
      EXPECT_EQ(facets.stored[0].slope, Vec2(0, 0));
      EXPECT_EQ(facets.stored[0].spread, 0);
    }
  }
}

TEST(FacetDistribution, OfRidgesIsTwoFacets) {
  const FacetDistribution facets = facets_of(ridges(), {.sides = {k_ridge_side, 1}});
  ASSERT_EQ(facets.count, 2u);
  for (const FacetGroup& group : facets.groups()) {
    EXPECT_EQ(group.share, 0.5);
    EXPECT_EQ(std::abs(group.slope.x()), 0.5);
    EXPECT_EQ(group.slope.y(), 0);
    EXPECT_EQ(group.spread, 0);
  }
  EXPECT_EQ(facets.mean_slope(), Vec2(0, 0));
}

TEST(FacetDistribution, OfAMapWithBordersHasFlatOnes) {
  // From middle to middle it rises by 1; half a texel at each end is flat. A quarter of each, twice.
  const DisplacementMap map(2, 1, {0, 1}, MapBorder::clamped);
  const FacetDistribution facets = facets_of(map);
  ASSERT_EQ(facets.count, 2u);
  for (const FacetGroup& group : facets.groups()) {
    EXPECT_EQ(group.share, 0.5);
    EXPECT_TRUE(group.slope == Vec2(0, 0) || group.slope == Vec2(2, 0)) << group.slope.transpose();
  }
}

TEST(FacetDistribution, StaysAsItIsUpToFourteenSlopes) {
  std::vector<FacetGroup> groups = random_groups(1, 14, 0.5);
  const double total = [&] {
    double sum = 0;
    for (const FacetGroup& group : groups) sum += group.share;
    return sum;
  }();
  groups.push_back(groups[3]);  // again the same slope
  groups.back().share = groups[3].share /= 2;
  const FacetDistribution merged = merge_facets(groups);
  ASSERT_EQ(merged.count, 14u);
  for (std::size_t k = 0; k < 14; ++k) {
    const auto found =
        std::find_if(merged.groups().begin(), merged.groups().end(),
                     [&](const FacetGroup& group) { return (group.slope - groups[k].slope).norm() < 1e-12; });
    ASSERT_NE(found, merged.groups().end()) << k;
    EXPECT_NEAR(found->share, groups[k].share / total * (k == 3 ? 2 : 1), 1e-12);
    EXPECT_NEAR(found->spread, groups[k].spread, 1e-7);  // the root of a difference of squares
  }
}

TEST(FacetDistribution, KeepsMeanSlopeAndMeanSquareWhenGroupsAreMerged) {
  for (const double steepness : {0.1, 1.0, 20.0}) {
    const std::vector<FacetGroup> groups = random_groups(2, 400, steepness);
    const FacetDistribution merged = merge_facets(groups);
    Vec2 mean = Vec2::Zero();
    double shares = 0;
    for (const FacetGroup& group : groups) {
      mean += group.share * group.slope;
      shares += group.share;
    }
    EXPECT_LE(merged.count, FacetDistribution::k_most_groups);
    EXPECT_NEAR(sum_of_shares(merged), 1, 1e-12);
    EXPECT_LT((merged.mean_slope() - mean / shares).norm(), 1e-12 * (1 + steepness));
    EXPECT_NEAR(mean_square(merged.groups()), mean_square(groups), 1e-9 * (1 + steepness * steepness));
  }
}

TEST(FacetDistribution, IsRoundedAsStatedInSixtyFourBytes) {
  static_assert(sizeof(PackedFacets) == 64);
  const auto place_of = [](const Vec2& slope) {
    const Vec3 normal = Vec3(-slope.x(), -slope.y(), 1).normalized();
    return Vec2(normal.head<2>() / std::sqrt(1 + normal.z()));
  };
  for (unsigned seed = 0; seed < 50; ++seed) {
    const FacetDistribution facets = merge_facets(random_groups(seed, 14, 0.1 + seed));
    const FacetDistribution rounded = PackedFacets(facets).unpacked();
    EXPECT_NEAR(sum_of_shares(rounded), 1, 1e-12);
    Vec2 least(1, 1), largest(-1, -1);
    for (const FacetGroup& group : facets.groups()) {
      least = least.cwiseMin(place_of(group.slope));
      largest = largest.cwiseMax(place_of(group.slope));
    }
    // The square's middle is rounded to eight bits, and its side then up, so that it is a little wider.
    const double half_side = (largest - least).maxCoeff() / 2 * 1.01 + 0.008;
    for (const FacetGroup& group : facets.groups()) {
      if (group.share < 1.0 / 255) continue;  // may be lost
      const auto is_rounded = [&](const FacetGroup& found) {
        const double apart = (place_of(found.slope) - place_of(group.slope)).cwiseAbs().maxCoeff();
        return std::abs(found.share - group.share) < 1.0 / 255 && apart <= 0.5 * half_side / 127 + 1e-5;
      };
      EXPECT_TRUE(std::ranges::any_of(rounded.groups(), is_rounded))
          << seed << ' ' << group.slope.transpose();
    }
  }
}

TEST(FacetDistribution, IsUnchangedByRoundingTwice) {
  const PackedFacets packed(facets_of(test::random_waves(1, 0.2)));
  // Places that are whole steps stay so, in a square that the same places make.
  const FacetDistribution once = packed.unpacked(), twice = PackedFacets(once).unpacked();
  ASSERT_EQ(twice.count, once.count);
  for (std::size_t k = 0; k < once.count; ++k) {
    EXPECT_EQ(twice.stored[k].share, once.stored[k].share);
    EXPECT_LT((twice.stored[k].slope - once.stored[k].slope).norm(), 1e-9);
  }
}

TEST(FacetLevels, HaveATexelOfSixtyFourBytesForEachOfTheMapAndOfItsLevels) {
  const DisplacementMap map = test::random_waves(1, 0.2, 32);
  const FacetLevels levels(map);
  ASSERT_EQ(levels.count(), 6);
  EXPECT_EQ(levels.columns(0), 32);
  EXPECT_EQ(levels.columns(5), 1);
  EXPECT_EQ(levels.bytes(), 64u * (1024 + 256 + 64 + 16 + 4 + 1));
  EXPECT_EQ(levels.texel(5, 0, 0), PackedFacets(facets_of(map)));
}

TEST(FacetLevels, OfMapsThatArentSquareEndInOneTexel) {
  const DisplacementMap map(5, 2, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  const FacetLevels levels(map);
  ASSERT_EQ(levels.count(), 4);  // 5 x 2, 3 x 1, 2 x 1, 1 x 1
  EXPECT_EQ(levels.columns(1), 3);
  EXPECT_EQ(levels.rows(1), 1);
  EXPECT_EQ(levels.columns(2), 2);
  EXPECT_EQ(levels.texel(3, 0, 0), PackedFacets(facets_of(map)));
  // The last texel of level 1 has the map's last column only, half of which lies beyond the last middle.
  const FacetDistribution last = levels.texel(1, 2, 0).unpacked();
  double flat = 0;
  for (const FacetGroup& group : last.groups()) flat += std::abs(group.slope.x()) < 0.1 ? group.share : 0.0;
  EXPECT_NEAR(flat, 0.5, 1.0 / 255);
}

TEST(FacetLevels, ShowAsMuchAreaAsTheFourTexelsBelow) {
  const DisplacementMap map = test::random_waves(3, 0.1, 64);
  const FacetLevels levels(map);
  double largest = 0, differences = 0, areas = 0;
  for (int level = 1; level < levels.count(); ++level) {
    for (int at = 0; at < levels.columns(level) * levels.rows(level); ++at) {
      const int x = at % levels.columns(level), y = at / levels.columns(level);
      const FacetDistribution facets = levels.texel(level, x, y).unpacked();
      for (const double degrees : {20.0, 50.0, 75.0}) {
        const Vec3 direction = test::direction_at(degrees * std::numbers::pi / 180, 0.7 * at);
        double below = 0;
        for (int k = 0; k < 4; ++k)
          below +=
              area_toward(levels.texel(level - 1, 2 * x + k % 2, 2 * y + k / 2).unpacked(), direction) / 4;
        const double difference = std::abs(area_toward(facets, direction) - below);
        largest = std::max(largest, difference);
        differences += difference;
        areas += below;
      }
    }
  }
  // Normals are rounded by half of 1/127 of about half the disk, on slopes of about 1; and facets in one
  // group that just look away count for those that just don't.
  EXPECT_LT(differences, 0.01 * areas);
  EXPECT_LT(largest, 0.05);
}

TEST(FacetLevels, AreTheSameForAnyNumberOfThreads) {
  const DisplacementMap map = test::random_waves(4, 0.1, 64);
  const FacetLevels many(map);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const FacetLevels one(map);
  for (int level = 0; level < many.count(); ++level) {
    for (int y = 0; y < many.rows(level); ++y) {
      for (int x = 0; x < many.columns(level); ++x)
        ASSERT_EQ(many.texel(level, x, y), one.texel(level, x, y)) << level << ' ' << x << ' ' << y;
    }
  }
}

TEST(FacetDistribution, HoldsSpikesAndSlopesBeyondEightyDegrees) {
  for (const float height : {1.0f, 6.0f, 100.0f, 1e6f, 3e38f}) {
    std::vector<float> heights(64, 0.0f);
    heights[27] = height;
    const DisplacementMap map(8, 8, heights, MapBorder::periodic);
    const FacetDistribution facets = PackedFacets(facets_of(map)).unpacked();
    EXPECT_NEAR(sum_of_shares(facets), 1, 1e-12);
    double flat = 0;
    for (const FacetGroup& group : facets.groups()) {
      ASSERT_TRUE(group.slope.allFinite() && std::isfinite(group.spread)) << height;
      if (group.slope.norm() < 1e-6) flat += group.share;
    }
    // Four cells of 64 aren't flat, and shares are whole parts of 255.
    EXPECT_NEAR(flat, 60.0 / 64, 14.0 / 255) << height;
  }
}

TEST(FacetDistribution, RefusesWhatArentNumbersOrFacets) {
  const DisplacementMap map = ridges();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(facets_of(map, {.sides = {0, 1}}), OptionError);
  EXPECT_THROW(facets_of(map, {.sides = {1, nan}}), OptionError);
  EXPECT_THROW(facets_of(map, {.samples = 0}), OptionError);
  EXPECT_THROW(FacetLevels(map, {.samples = 65}), OptionError);
  EXPECT_THROW(DisplacementMap(1, 1, {std::numeric_limits<float>::quiet_NaN()}), InputError);
  EXPECT_THROW(merge_facets({}), InputError);
  for (const FacetGroup& group :
       {FacetGroup{.share = nan}, FacetGroup{.share = 0}, FacetGroup{.share = -1},
        FacetGroup{.share = 1, .slope = {nan, 0}}, FacetGroup{.share = 1, .spread = -1},
        FacetGroup{.share = 1, .slope = {0, 2e6}}})
    EXPECT_THROW(merge_facets({&group, 1}), InputError);
}

TEST(FacetLevels, CanBeCancelled) {
  test::Cancelling cancelling;
  EXPECT_THROW(FacetLevels(ridges(), {}, &cancelling), Cancelled);
}

}  // namespace
}  // namespace recede
