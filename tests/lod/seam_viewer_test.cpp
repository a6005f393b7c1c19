#include "sanitized.h"
#include "seam_models.h"
#include "seam_views.h"
#include <recede/geometry/error.h>
#include <recede/lod/seam_viewer.h>

#include <gtest/gtest.h>

namespace recede {
namespace {

SeamModel model_of(const std::vector<TrimmedPatch>& patches, double tolerance) {
  SeamModelOptions options;
  options.seams.tolerance = tolerance;
  return build_seam_model(test::part_of(patches), options);
}

// A pixel covers 2e-3 of the distance.
SeamView looking(const Vec3& position, const Vec3& target) {
  SeamView view;
  view.position = position;
  view.target = target;
  view.up = Vec3(0.1, 0.9, 0.3);
  view.view = {.image_height = 1000, .field_of_view = std::numbers::pi / 2, .pixel_error = 0.5};
  return view;
}

// The boxes of surfaces are rounded outwards in single precision.
constexpr double k_box_rounding = 1e-6;

TEST(SeamViewer, MakesPatchesForThreeFourthsOfHalfAPixelWhereTheyAreNearest) {
  const SeamModel square =
      model_of({test::whole(test::parallelogram(Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY()))}, 0.01);
  SeamViewer viewer(square);
  const auto tolerance_at = [&](const Vec3& eye) {
    return viewer.update(looking(eye, {0.5, 0.5, 0})).finest_tolerance;
  };
  const auto expect_at = [&](const Vec3& eye, double tolerance) {
    EXPECT_NEAR(tolerance_at(eye), tolerance, k_box_rounding * tolerance) << eye.transpose();
  };
  expect_at({0.5, 0.5, 5}, 0.75 * 5e-3);
  // Half a pixel is still more than what it was made for, then less, then at most twice as much, then more.
  expect_at({0.5, 0.5, 4}, 0.75 * 5e-3);
  expect_at({0.5, 0.5, 3}, 0.75 * 3e-3);
  expect_at({0.5, 0.5, 4}, 0.75 * 3e-3);
  expect_at({0.5, 0.5, 5}, 0.75 * 5e-3);
  // From a corner of the square, in a diagonal of a box.
  expect_at({-6, -8, 10}, 0.75e-3 * std::sqrt(36 + 64 + 100));
  // A tenth of the seams' error at least.
  expect_at({0.5, 0.5, 0.9}, 0.75e-3);
  expect_at({0.5, 0.5, 1e-6}, 0.75e-3);
}

TEST(SeamViewer, SaysHowManyPixelsPatchesWereMadeFor) {
  const SeamModel square =
      model_of({test::whole(test::parallelogram(Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY()))}, 0.01);
  SeamViewer viewer(square);
  SeamView view = looking({0.5, 0.5, 5}, {0.5, 0.5, 0});
  EXPECT_NEAR(viewer.update(view).pixel_error, 0.375, k_box_rounding);
  view.position.z() = 4;
  EXPECT_NEAR(viewer.update(view).pixel_error, 0.375 * 5 / 4, k_box_rounding);
  view.view.pixel_error = 2;
  view.position.z() = 6;
  EXPECT_NEAR(viewer.update(view).pixel_error, 1.5, k_box_rounding);
}

TEST(SeamViewer, CullsFivePatchesOfABoxSeenFromTheFrontAndNoneOfAnOpenOne) {
  std::vector<TrimmedPatch> faces = test::box_faces({3, 2, 1});
  const SeamModel box = model_of(faces, 1e-3);
  SeamViewer viewer(box);
  SeamView view = looking({10, 1, 0.5}, {1.5, 1, 0.5});
  const SeamFrame front = viewer.update(view);
  EXPECT_EQ(front.culled_patches, 5u);
  EXPECT_FALSE(viewer.is_culled(5)) << faces[5].name;
  EXPECT_EQ(front.drawn_patches, 1u);
  EXPECT_EQ(front.drawn_triangles, 2u);
  // Three faces from a corner; none when the box is behind the eye or beside the image.
  view.position = {10, 10, 10};
  EXPECT_EQ(viewer.update(view).culled_patches, 3u);
  view.target = {20, 20, 20};
  EXPECT_EQ(viewer.update(view).culled_patches, 6u);
  EXPECT_EQ(viewer.update(looking({10, 1, 0.5}, {10, 20, 0.5})).culled_patches, 6u);
  // Where a face is missing, the others may be seen from inside.
  faces.pop_back();
  const SeamModel open = model_of(faces, 1e-3);
  SeamViewer of_open(open);
  EXPECT_EQ(of_open.update(looking({10, 1, 0.5}, {1.5, 1, 0.5})).culled_patches, 0u);
}

TEST(SeamViewer, CullsNothingOfABodyThatAViewFromInsideShows) {
  std::vector<TrimmedPatch> faces = test::box_faces({3, 2, 1});
  for (TrimmedPatch& face : faces) face.is_reversed = true;
  const SeamModel room = model_of(faces, 1e-3);
  SeamViewer viewer(room);
  // Of a room from its middle, four walls are beside an image of 90 degrees or reach into it.
  SeamView view = looking({1.5, 1, 0.5}, {3, 1, 0.5});
  viewer.update(view);
  EXPECT_FALSE(viewer.is_culled(5));
  EXPECT_TRUE(viewer.is_culled(4));  // behind
}

// Balls in a row before the eye, at distances of 4, 12 and 24, and one behind it at 2.
std::vector<TrimmedPatch> row_of_balls() {
  return {test::whole(test::ball(1, {20, 0, 0})), test::whole(test::ball(1, {-8, 0, 0})),
          test::whole(test::ball(1, {0, 0, 0})), test::whole(test::ball(1, {8, 0, 0}))};
}

TEST(SeamViewer, RefinesTheLargestPixelErrorFirstAndWhatIsCulledLast) {
  const SeamModel model = model_of(row_of_balls(), 1e-3);
  SeamViewer viewer(model);
  SeamView view = looking({-5, 0, 0}, {0, 0, 0});
  view.most_new_triangles = 1;
  double last_error = std::numeric_limits<double>::infinity();
  const std::array<std::size_t, 4> order{2, 3, 0, 1};
  for (std::size_t round = 0; round < 4; ++round) {
    const SeamFrame frame = viewer.update(view);
    EXPECT_EQ(frame.postponed, 3 - round);
    if (round > 0) {
      EXPECT_EQ(frame.update.tessellated, 1u) << round;
    }
    EXPECT_EQ(frame.culled_patches, 1u);
    EXPECT_TRUE(viewer.is_culled(1));
    if (round < 3) {
      EXPECT_LT(frame.pixel_error, last_error);
      EXPECT_EQ(frame.pixel_error > 0.5, round < 2);
    }
    last_error = frame.pixel_error;
    for (std::size_t i = 0; i < 4; ++i) {
      const double distance = std::array{24, 2, 4, 12}[order[i]];
      const double half_a_pixel = 1e-3 * distance * (order[i] == 1 ? view.culled_factor : 1);
      const double bound = viewer.tessellation().triangles_of(order[i]).error_bound;
      EXPECT_EQ(bound <= half_a_pixel, i <= round) << "frame " << round << ", ball " << order[i];
    }
  }
  EXPECT_EQ(viewer.update(view).update.tessellated, 0u);
}

TEST(SeamViewer, CatchesUpInLaterFramesWithWhatItsBudgetPostponed) {
  const std::vector<TrimmedPatch> patches =
      test::together({test::tiled_box({3, 2, 1}, 4), test::moved(test::ring(1, 0.5, 0.7), {5, 0, 0})});
  const SeamModel model = model_of(patches, 1e-3);
  const test::LevelChecker checker("box and ring", patches, model);
  SeamViewer hurried(model), patient(model);
  SeamView view = looking({4, 3, 5}, {3, 0, 0});
  const SeamFrame all = patient.update(view);
  EXPECT_EQ(all.postponed, 0u);
  view.most_new_triangles = 20;
  SeamFrame frame = hurried.update(view);
  EXPECT_GT(frame.postponed, 0u);
  EXPECT_GT(frame.pixel_error, all.pixel_error);
  int n_frames = 1;
  for (std::size_t before = frame.postponed; frame.postponed > 0; before = frame.postponed) {
    frame = hurried.update(view);
    checker.expect_closed(hurried.tessellation(), frame.update);
    ASSERT_LT(frame.postponed, before);
    ++n_frames;
  }
  EXPECT_GT(n_frames, 5);
  EXPECT_EQ(frame.pixel_error, all.pixel_error);
  EXPECT_EQ(frame.drawn_triangles, all.drawn_triangles);
  EXPECT_EQ(frame.drawn_patches, all.drawn_patches);
}

TEST(SeamViewer, MakesNothingAnewForTheSameViewAndForASmallStep) {
  for (const test::NamedPatches& named : test::closed_models()) {
    const SeamModel model = model_of(named.patches, 0);
    SeamViewer viewer(model);
    const Vec3 middle = test::box_of(model).center();
    SeamView view = looking(middle + 3 * model.size * Vec3(0.6, 0.64, 0.48), middle);
    EXPECT_GT(viewer.update(view).update.tessellated, 0u);
    for (const double distance : {3.0, 2.9, 2.8, 3.1}) {
      view.position = middle + distance * model.size * Vec3(0.6, 0.64, 0.48);
      const SeamFrame frame = viewer.update(view);
      EXPECT_EQ(frame.update.tessellated, 0u) << named.name << " from " << distance;
      EXPECT_EQ(frame.update.moves.splits + frame.update.moves.merges, 0u) << named.name;
      EXPECT_EQ(frame.postponed, 0u);
    }
  }
}

TEST(SeamViewer, MakesNothingAnewForTheSameViewHoweverNear) {
  // Nearer than the seams' own error patches are refused again and again, and others need finer seams.
  for (const test::NamedPatches& named : test::closed_models()) {
    const SeamModel model = model_of(named.patches, 0.01);
    SeamViewer viewer(model);
    std::mt19937 random(62);
    for (int round = 0; round < (test::k_sanitized ? 3 : 30); ++round) {
      const SeamView view = test::random_view(model, random);
      viewer.update(view);
      const SeamFrame again = viewer.update(view);
      EXPECT_EQ(again.update.tessellated, 0u) << named.name << ", view " << round;
      EXPECT_EQ(again.update.moves.splits + again.update.moves.merges, 0u) << named.name;
    }
  }
}

TEST(SeamViewer, ShowsTheSameWithAndWithoutFramesBefore) {
  // For views that tolerate at most a half or at least twice as much as the one before, of patches that are
  // seen.
  const std::vector<TrimmedPatch> patches = test::pillow(0.8);
  const SeamModel model = model_of(patches, 1e-3);
  SeamViewer walker(model);
  const Vec3 middle = test::box_of(model).center();
  for (const double distance : {40.0, 10.0, 3.0, 9.0, 50.0}) {
    const SeamView view = looking(middle + distance * Vec3(0.6, 0.64, 0.48), middle);
    SeamViewer newcomer(model);
    const SeamFrame frame = walker.update(view), fresh = newcomer.update(view);
    EXPECT_EQ(frame.finest_tolerance, fresh.finest_tolerance) << distance;
    EXPECT_EQ(frame.pixel_error, fresh.pixel_error) << distance;
    EXPECT_EQ(frame.drawn_triangles, fresh.drawn_triangles) << distance;
  }
}

TEST(SeamViewer, IsClosedAndWithinHalfAPixelForTwoHundredViewsOfClosedModels) {
  for (const test::NamedPatches& named : test::closed_models()) {
    const SeamModel model = model_of(named.patches, 0.01);  // coarse, so that near views take no time
    test::expect_sound_views(named.name, named.patches, model, test::k_sanitized ? 10 : 200);
  }
}

TEST(SeamViewer, RefusesViewsOfNothing) {
  const SeamModel box = model_of(test::box_faces({3, 2, 1}), 1e-3);
  SeamViewer viewer(box);
  const auto refuses = [&](auto change) {
    SeamView view;
    change(view);
    EXPECT_THROW(viewer.update(view), OptionError);
  };
  refuses([](SeamView& view) { view.view.pixel_error = 0; });
  refuses([](SeamView& view) { view.view.pixel_error = NAN; });
  refuses([](SeamView& view) { view.view.image_height = 0; });
  refuses([](SeamView& view) { view.view.field_of_view = std::numbers::pi; });
  refuses([](SeamView& view) { view.aspect_ratio = 0; });
  refuses([](SeamView& view) { view.culled_factor = 0.5; });
  refuses([](SeamView& view) { view.target = view.position; });
  refuses([](SeamView& view) { view.up = view.target - view.position; });
  refuses([](SeamView& view) { view.position.x() = NAN; });
}

}  // namespace
}  // namespace recede
