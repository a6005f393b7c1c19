#include "input_errors.h"
#include "simple_soups.h"
#include <recede/geometry/error.h>
#include <recede/lod/lod_selection.h>

#include <gtest/gtest.h>

namespace recede {
namespace {

/// Levels of fewer and fewer faces, and errors that grow with what is missing.
LodHierarchy five_levels() {
  LodHierarchy hierarchy;
  for (const Index side : {10u, 9u, 8u, 6u, 4u}) {
    const PolygonSoup grid = test::grid(side);
    LodLevel& level = hierarchy.levels.emplace_back();
    level.mesh = repair_to_polygon_mesh(grid).mesh;
    level.error.bound = 1e-3 * (10.0 - side);
  }
  return hierarchy;
}

TEST(LevelByError, IsTheCoarsestThatTheViewPermits) {
  const LodHierarchy hierarchy = five_levels();
  LevelByErrorOptions options;
  EXPECT_EQ(level_by_error(hierarchy, -1, options), 0u);
  EXPECT_EQ(level_by_error(hierarchy, 0, options), 0u);
  EXPECT_EQ(level_by_error(hierarchy, 1e9, options), 4u);
  for (std::size_t level = 1; level < 5; ++level) {
    const double limit = switch_distance(hierarchy.levels[level].error.bound, options.view);
    EXPECT_EQ(level_by_error(hierarchy, limit, options), level);
    EXPECT_EQ(level_by_error(hierarchy, limit * (1 - 1e-12), options), level - 1);
  }
}

TEST(LevelByError, StaysWhereAChangeWouldPayLittle) {
  const LodHierarchy hierarchy = five_levels();
  LevelByErrorOptions options;
  options.hysteresis = 0.2;
  const double limit = switch_distance(hierarchy.levels[3].error.bound, options.view);
  options.current = 2;
  EXPECT_EQ(level_by_error(hierarchy, 1.1 * limit, options), 2u) << "not yet far enough for a coarser one";
  EXPECT_EQ(level_by_error(hierarchy, 1.26 * limit, options), 3u);
  options.current = 3;
  EXPECT_EQ(level_by_error(hierarchy, 1.1 * limit, options), 3u) << "and back only where it must";
  EXPECT_EQ(level_by_error(hierarchy, 0.999 * limit, options), 2u);
}

// The source's table: shares 100, 80, 60, 40, 20 % from 0, 1.25, 1.66, 2.5 and 5 on.
TEST(LevelByDistance, FollowsTheSharesOfTheFaces) {
  LodHierarchy hierarchy;
  for (const int faces : {10, 8, 6, 4, 2}) {
    PolygonSoup strip;
    for (int i = 0; i <= faces; ++i) {
      strip.positions.emplace_back(i, 0, 0);
      strip.positions.emplace_back(i, 1, 0);
    }
    for (Index i = 0; i < static_cast<Index>(faces); ++i) {
      strip.add_face(std::array<Index, 4>{2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1});
    }
    hierarchy.levels.emplace_back().mesh = repair_to_polygon_mesh(strip).mesh;
  }
  const auto level = [&](double distance) { return level_by_distance(hierarchy, distance, distance); };
  EXPECT_EQ(level(0.05), 0u);
  EXPECT_EQ(level(1.24), 0u);
  EXPECT_EQ(level(1.26), 1u);
  EXPECT_EQ(level(1.67), 2u);
  EXPECT_EQ(level(2.51), 3u);
  EXPECT_EQ(level(4.99), 3u);
  EXPECT_EQ(level(5.01), 4u);
  EXPECT_EQ(level_by_distance(hierarchy, 10.02, 10.02, {.unit = 2}), 4u);
  // Very near: the coarsest, but only near the surface, not wherever the sphere is.
  const LevelByDistanceOptions near{.unit = 1, .near_limit = 0.1};
  EXPECT_EQ(level_by_distance(hierarchy, -0.5, 0.05, near), 4u);
  EXPECT_EQ(level_by_distance(hierarchy, -0.5, 0.5, near), 0u);
}

TEST(LevelSelection, RefusesWhatIsOutOfRange) {
  const LodHierarchy hierarchy = five_levels();
  EXPECT_THROW(level_by_error({}, 1), InputError);
  EXPECT_THROW(level_by_distance({}, 1, 1), InputError);
  EXPECT_THROW(level_by_error(hierarchy, 1, {.view = {}, .hysteresis = 1}), OptionError);
  EXPECT_THROW(level_by_error(hierarchy, 1, {.view = {.pixel_error = 0}}), OptionError);
  EXPECT_THROW(level_by_distance(hierarchy, 1, 1, {.unit = 0}), OptionError);
  EXPECT_THROW(level_by_distance(hierarchy, 1, 1, {.unit = 1, .near_limit = -1}), OptionError);
}

}  // namespace
}  // namespace recede
