#include "sanitized.h"
#include "uv_ball.h"
#include <recede/geometry/error.h>
#include <recede/geometry/sample_models.h>
#include <recede/lod/octahedral_impostor.h>
#include <recede/render/far_level.h>
#include <recede/render/renderer.h>

#include <gmock/gmock.h>

#include <cmath>

namespace recede {
namespace {

using test::k_sanitized;
using test::uv_ball;
using testing::HasSubstr;

LodHierarchy hierarchy_of(const PolygonSoup& model) {
  HierarchyOptions options;
  options.ratios = {0.25, 0.05};
  return build_hierarchy(repair_to_polygon_mesh(model).mesh, "model", options);
}

TEST(FarLevels, OfATreeAreBillboards) {
  LodHierarchy hierarchy = hierarchy_of(make_tree({.leaves = k_sanitized ? 300u : 2400u}));
  FarLevelOptions options;
  options.relative_errors = {0.08};
  options.views = 6;
  std::vector<FarLevelTrial> trials = compare_far_levels(hierarchy, options);
  ASSERT_EQ(trials.size(), 1u);
  const FarLevelTrial& trial = trials[0];
  EXPECT_TRUE(trial.takes_billboards) << trial.reason;
  EXPECT_THAT(trial.reason, HasSubstr("billboards: pictures of"));
  EXPECT_LT(trial.billboard_difference, trial.triangle_difference);
  EXPECT_LE(trial.triangle_bytes, trial.billboard_bytes);
  EXPECT_GT(5 * trial.triangle_bytes, 4 * trial.billboard_bytes);  // else the comparison wouldn't be one
  EXPECT_EQ(append_far_levels(hierarchy, trials), 1u);
  const LodLevel& last = hierarchy.levels.back();
  ASSERT_TRUE(last.billboards.has_value());
  EXPECT_EQ(last.stop_reason, trial.reason);
  EXPECT_GT(last.switch_distance, 0);
  for (std::size_t i = 1; i < hierarchy.levels.size(); ++i)
    EXPECT_GE(hierarchy.levels[i].switch_distance, hierarchy.levels[i - 1].switch_distance);
}

TEST(FarLevels, OfABallAreTriangles) {
  LodHierarchy hierarchy = hierarchy_of(uv_ball(40));
  std::vector<FarLevelTrial> trials = compare_far_levels(hierarchy, {.relative_errors = {0.02}, .views = 6});
  ASSERT_EQ(trials.size(), 1u);
  EXPECT_FALSE(trials[0].takes_billboards) << trials[0].reason;
  EXPECT_THAT(trials[0].reason, HasSubstr("triangles: "));
  EXPECT_EQ(append_far_levels(hierarchy, trials), 0u);
  EXPECT_EQ(hierarchy.levels.size(), 3u);
}

TEST(FarLevels, SayWhichLevelsTheyReplace) {
  HierarchyOptions options;
  options.ratios = {0.25, 0.001};
  LodHierarchy hierarchy =
      build_hierarchy(repair_to_polygon_mesh(make_tree({.leaves = 300})).mesh, "model", options);
  ASSERT_EQ(hierarchy.levels.size(), 3u);
  std::vector<FarLevelTrial> trials = compare_far_levels(hierarchy, {.relative_errors = {0.08}, .views = 6});
  ASSERT_LT(1.5 * trials[0].error, hierarchy.levels[2].error.bound);
  ASSERT_EQ(append_far_levels(hierarchy, trials), 1u) << trials[0].reason;
  EXPECT_THAT(trials[0].reason, HasSubstr("replace"));
  EXPECT_EQ(hierarchy.levels.back().stop_reason, trials[0].reason);
}

// Of a file that is larger than memory level 0 is off itself, and clouds are made from that.
TEST(FarLevels, AreOffByWhatLevelZeroIsAsWell) {
  LodHierarchy exact = hierarchy_of(make_tree({.leaves = 300})), off = exact;
  off.levels[0].error = {.max = 0.3, .rms = 0.1, .bound = 0.4};
  for (LodHierarchy* hierarchy : {&exact, &off}) {
    std::vector<FarLevelTrial> trials =
        compare_far_levels(*hierarchy, {.relative_errors = {0.08}, .views = 6});
    ASSERT_EQ(append_far_levels(*hierarchy, trials), 1u) << trials[0].reason;
  }
  const LevelError &without = exact.levels.back().error, &with = off.levels.back().error;
  EXPECT_DOUBLE_EQ(with.max, without.max + 0.3);
  EXPECT_DOUBLE_EQ(with.rms, without.rms + 0.1);
  EXPECT_DOUBLE_EQ(with.bound, without.bound + 0.4);
}

TEST(FarLevels, OfVeryManyFacesAreLeftAlone) {
  const LodHierarchy hierarchy = hierarchy_of(make_tree({.leaves = 100}));
  const std::vector<FarLevelTrial> trials =
      compare_far_levels(hierarchy, {.relative_errors = {0.08}, .views = 6, .most_faces = 10});
  EXPECT_FALSE(trials[0].takes_billboards);
  EXPECT_THAT(trials[0].reason, HasSubstr("too many to merge"));
}

TEST(FarLevels, RefuseWhatHasNoMeaning) {
  const LodHierarchy hierarchy = hierarchy_of(uv_ball(10));
  EXPECT_THROW(compare_far_levels(hierarchy, {.relative_errors = {0.02, 0.01}}), OptionError);
  EXPECT_THROW(compare_far_levels(hierarchy, {.relative_errors = {0}}), OptionError);
  EXPECT_THROW(compare_far_levels(hierarchy, {.views = 1}), OptionError);
  EXPECT_THROW(compare_far_levels(LodHierarchy{}, {}), InputError);
}

TEST(FarLevels, CountTheBytesOfMeshes) {
  PolygonSoup square;
  square.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  square.add_face(std::array<Index, 4>{0, 1, 2, 3});
  EXPECT_EQ(mesh_bytes(to_polygon_mesh(square)), 4u * 28 + 2 * 12);
}

TEST(OctahedralImpostor, LooksLikeItsModel) {
  const PolygonSoup model = uv_ball(40);
  const PlacedBillboards placed{
      std::make_shared<const BillboardTextures>(octahedral_impostor_within(model, 2'000'000, 8))};
  const Scene cloud(std::span<const PolygonSoup>{}, std::span<const PlacedBillboards>(&placed, 1)),
      original(model);
  for (const Vec3& from : {Vec3(1, 2, 3), Vec3(-3, 0.5, -1), Vec3(0.2, -3, 0.1)}) {
    Camera camera{.position = from, .width = 60, .height = 60};
    const Image a = render(original, camera), b = render(cloud, camera);
    double sum = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) sum += (a.pixels[i] - b.pixels[i]).cwiseAbs().sum() / 3;
    // Heights of 8 bits over the whole depth, and pixels at the outline.
    EXPECT_LT(sum / static_cast<double>(a.pixels.size()), 0.015);
  }
}

}  // namespace
}  // namespace recede
