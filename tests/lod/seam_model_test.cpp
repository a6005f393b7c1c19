#include "same_bits.h"
#include "sanitized.h"
#include "seam_level_checks.h"
#include "seam_models.h"
#include <recede/geometry/error.h>
#include <recede/lod/seam_model.h>

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

namespace recede {
namespace {

using test::closed_models;
using test::NamedPatches;
using test::part_of;

SeamModel model_of(const std::vector<TrimmedPatch>& patches, double tolerance = 0) {
  SeamGraphOptions options;
  options.tolerance = tolerance;
  return build_seam_model(part_of(patches), {options, {}});
}

TEST(SeamModel, OfABoxHasTwelveTrianglesOnTheFinestLevelAndTwoOnTheCoarsest) {
  const SeamModel box = model_of(test::box_faces({3, 2, 1}));
  EXPECT_EQ(box.turned, 0u);
  EXPECT_EQ(box.names[1], "top");
  EXPECT_NEAR(box.size, std::sqrt(14.0), 1e-12);
  SeamTessellation tessellation(box);
  const SeamUpdate fine = tessellation.update(1e-3);
  EXPECT_EQ(fine.triangles, 12u);
  EXPECT_EQ(fine.patches, 6u);
  EXPECT_EQ(fine.tessellated, 6u);
  EXPECT_EQ(fine.inverted + fine.tightened + fine.refused.size(), 0u);
  EXPECT_LE(fine.error_bound, 1e-12);
  const PolygonSoup soup = tessellation.soup();
  EXPECT_EQ(soup.positions.size(), 8u);
  EXPECT_TRUE(test::open_sides(soup).empty());
  // From outside, all volumes are added.
  EXPECT_NEAR(test::volume_of(soup), 6, 1e-12);
  const SeamUpdate coarse = tessellation.update(1e3);
  EXPECT_EQ(coarse.triangles, 2u);
  EXPECT_EQ(coarse.patches, 2u);
  EXPECT_LE(coarse.error_bound, 1e3);
  EXPECT_TRUE(test::open_sides(tessellation.soup()).empty());
}

TEST(SeamModel, IsClosedAndWithinItsBoundsOnEveryLevel) {
  for (const NamedPatches& named : closed_models()) {
    const SeamModel model = model_of(named.patches);
    test::LevelChecker checker(named.name, named.patches, model);
    SeamTessellation tessellation(model);
    for (double tolerance = 2e-3 * model.size; tolerance < 2 * model.size; tolerance *= 2) {
      const SeamUpdate update = tessellation.update(tolerance);
      checker.expect_closed(tessellation, update);
      checker.expect_within(tessellation, update, tolerance, 1000);
    }
  }
}

TEST(SeamModel, HasOutwardNormalsAndAboutItsVolume) {
  for (const NamedPatches& named : closed_models()) {
    const SeamModel model = model_of(named.patches);
    SeamTessellation tessellation(model);
    tessellation.update(1e-3 * model.size);
    const PolygonSoup soup = tessellation.soup();
    validate(soup, named.name);
    EXPECT_GT(test::volume_of(soup), 0) << named.name;
    std::size_t n_against = 0;
    for (std::size_t f = 0; f < soup.n_faces(); ++f) {
      const Vec3 area = vector_area(soup, f);
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& normal = soup.corner_normals[3 * f + k];
        EXPECT_NEAR(normal.norm(), 1, 1e-9);
        n_against += area.dot(normal) < 0;
      }
    }
    EXPECT_EQ(n_against, 0u) << named.name;
  }
  // pi r^2 h: polygons of a tolerance of 1e-3 of a size of 3.5 hold 1 % less at most.
  const SeamModel can = model_of(test::can(1, 2));
  SeamTessellation tessellation(can);
  tessellation.update(1e-3 * can.size);
  EXPECT_NEAR(test::volume_of(tessellation.soup()), 2 * std::numbers::pi, 0.02 * std::numbers::pi);
}

TEST(SeamModel, IsClosedForAnyTolerancesOfPatches) {
  std::mt19937 random(41);
  for (const NamedPatches& named : closed_models()) {
    const SeamModel model = model_of(named.patches);
    test::LevelChecker checker(named.name, named.patches, model);
    SeamTessellation tessellation(model);
    for (int round = 0; round < (test::k_sanitized ? 8 : 60); ++round) {
      const std::vector<double> tolerances = test::random_tolerances(model, random);
      const SeamUpdate update = tessellation.update(tolerances);
      checker.expect_closed(tessellation, update);
      if (round % 4 == 0) checker.expect_within(tessellation, update, tolerances, 300);
    }
  }
}

TEST(SeamModel, IsClosedForWhatCamerasSee) {
  std::mt19937 random(42);
  for (const NamedPatches& named : closed_models()) {
    const SeamModel model = model_of(named.patches);
    test::LevelChecker checker(named.name, named.patches, model);
    SeamTessellation tessellation(model);
    for (int round = 0; round < (test::k_sanitized ? 10 : 200); ++round) {
      const std::vector<double> tolerances = test::camera_tolerances(model, random);
      checker.expect_closed(tessellation, tessellation.update(tolerances));
    }
  }
}

TEST(SeamModel, CanHaveFewerTrianglesThanPatches) {
  const SeamModel model = model_of(test::tiled_box({3, 2, 1}, 6));
  SeamTessellation tessellation(model);
  const SeamUpdate fine = tessellation.update(1e-4);
  EXPECT_EQ(fine.patches, 216u);
  EXPECT_EQ(fine.triangles, 432u);
  std::size_t least = fine.triangles;
  for (double tolerance = 0.05; tolerance < 3; tolerance *= 1.3) {
    const SeamUpdate update = tessellation.update(tolerance);
    least = std::min(least, update.triangles);
  }
  EXPECT_LT(least, 216u);
}

// Levels before may leave finer triangles, up to twice; those of the first update are what all others must
// come back to from far away.
TEST(SeamModel, HasTheSameTrianglesWhateverWasThereBeforeAndForAnyNumberOfThreads) {
  std::mt19937 random(43);
  for (const NamedPatches& named : closed_models()) {
    const SeamModel model = model_of(named.patches);
    SeamTessellation walking(model);
    for (int round = 0; round < 6; ++round) {
      const std::vector<double> tolerances = test::random_tolerances(model, random);
      walking.update(1e6 * model.size);
      walking.update(tolerances);
      SeamTessellation fresh(model);
      {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
        fresh.update(tolerances);
      }
      EXPECT_EQ(test::first_difference(walking.soup(), fresh.soup()), "") << named.name;
    }
  }
}

TEST(SeamModel, IsTheSameForAnyNumberOfThreads) {
  const std::vector<TrimmedPatch> patches = test::ring(1, 0.5, 0.7);
  const SeamModel one = [&] {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    return model_of(patches);
  }();
  const SeamModel two = model_of(patches);
  EXPECT_TRUE(test::same_bytes(one.graph.positions, two.graph.positions));
  EXPECT_TRUE(test::same_bytes(one.graph.slots, two.graph.slots));
  EXPECT_TRUE(test::same_bytes(one.hierarchy.errors, two.hierarchy.errors));
  EXPECT_TRUE(test::same_bytes(one.hierarchy.splits, two.hierarchy.splits));
  EXPECT_TRUE(test::same_bytes(one.hierarchy.changes, two.hierarchy.changes));
}

TEST(SeamModel, TriangulatesOnlyWhatChanges) {
  const SeamModel model = model_of(test::tiled_box({3, 2, 1}, 4));
  SeamTessellation tessellation(model);
  EXPECT_EQ(tessellation.update(0.01).tessellated, 96u);
  EXPECT_EQ(tessellation.update(0.01).tessellated, 0u);
  // Finer than needed, but not by half.
  EXPECT_EQ(tessellation.update(0.015).tessellated, 0u);
}

TEST(SeamModel, TurnsPatchesThatDoNotAgreeWithTheirNeighbours) {
  for (const NamedPatches& named : closed_models()) {
    std::vector<TrimmedPatch> patches = named.patches;
    if (patches.size() < 3) continue;
    patches[1].is_reversed = !patches[1].is_reversed;
    const SeamModel model = model_of(patches);
    EXPECT_EQ(model.turned, 1u) << named.name;
    SeamTessellation tessellation(model);
    test::LevelChecker(named.name, patches, model).expect_closed(tessellation, tessellation.update(0.02));
    EXPECT_GT(test::volume_of(tessellation.soup()), 0);
  }
}

TEST(SeamModel, RefusesTolerancesThatAreNoneOrOfOtherPatches) {
  const SeamModel box = model_of(test::box_faces({1, 1, 1}));
  SeamTessellation tessellation(box);
  for (const double tolerance : {0.0, -1.0, std::nan("")})
    EXPECT_THROW(tessellation.update(tolerance), OptionError);
  EXPECT_THROW(tessellation.update(std::vector<double>(5, 0.1)), OptionError);
  SeamGraphOptions options;
  options.tolerance = -1;
  EXPECT_THROW(build_seam_model(part_of(test::box_faces({1, 1, 1})), {options, {}}), OptionError);
}

TEST(SeamModel, OfNothingIsNothing) {
  const SeamModel nothing = model_of({});
  EXPECT_EQ(nothing.size, 0);
  SeamTessellation tessellation(nothing);
  EXPECT_EQ(tessellation.update(1).triangles, 0u);
  EXPECT_EQ(tessellation.soup().n_faces(), 0u);
}

// Units from a nanometre to a million kilometres, and models far from the origin.
TEST(SeamModel, WorksInAnyUnitsAndFarFromTheOrigin) {
  for (const NamedPatches& named : closed_models()) {
    for (const double scale : {1e-9, 1e-3, 1e9}) {
      const std::vector<TrimmedPatch> patches = test::moved(named.patches, Vec3::Zero(), scale);
      const SeamModel model = model_of(patches);
      test::LevelChecker checker(named.name, patches, model);
      SeamTessellation tessellation(model);
      for (const double share : {1e-3, 0.05, 0.4}) {
        const SeamUpdate update = tessellation.update(share * model.size);
        checker.expect_closed(tessellation, update);
        checker.expect_within(tessellation, update, share * model.size, 200);
      }
    }
    const std::vector<TrimmedPatch> far = test::moved(named.patches, {1e6, 1e6, -1e6});
    const SeamModel model = model_of(far);
    test::LevelChecker checker(named.name + " far away", far, model);
    SeamTessellation tessellation(model);
    for (const double share : {1e-3, 0.05})
      checker.expect_closed(tessellation, tessellation.update(share * model.size));
  }
}

// Whatever comes of bad patches, it has a name, and what is left is sound.
struct BadPatches {
  std::string name;
  std::vector<TrimmedPatch> patches;
};

std::vector<BadPatches> bad_models() {
  using test::line;
  const NurbsSurface square = test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const auto polygon = [&](const std::vector<Vec2>& points) {
    TrimmingLoop loop;
    for (std::size_t i = 0; i < points.size(); ++i)
      loop.curves.push_back(line(points[i], points[(i + 1) % points.size()]));
    return TrimmedPatch{square, {loop}, false, "bad"};
  };
  const TrimmedPatch good = test::whole(test::parallelogram({1, 0, 0}, {1, 0, 0}, {0, 1, 0}), "good");
  TrimmedPatch crossing_hole = test::whole(square, "bad");
  crossing_hole.loops.push_back(test::circle({0, 0.5}, 0.2, true));
  TrimmedPatch hole_outside = polygon({{0, 0}, {1, 0}, {1, 0.5}, {0, 0.5}});
  hole_outside.loops.push_back(test::circle({0.5, 0.8}, 0.1, true));
  TrimmedPatch hole_alone{square, {test::circle({0.5, 0.5}, 0.2, true)}, false, "bad"};
  NurbsSurface flat = square;
  for (Vec3& p : flat.points) p.y() = 0;
  NurbsSurface point = square;
  for (Vec3& p : point.points) p = Vec3(1, 1, 0);
  NurbsSurface twisted = square;
  std::swap(twisted.points[2], twisted.points[3]);
  return {
      {"loop that crosses itself", {polygon({{0, 0}, {1, 1}, {1, 0}, {0, 1}}), good}},
      {"loop with a knot",
       {polygon({{0, 0}, {1, 0}, {1, 1}, {0.5, 1}, {0.45, 1.02}, {0.5, 1.02}, {0.45, 1}, {0, 1}}), good}},
      {"loop without area", {polygon({{0, 0}, {1, 0}, {0.5, 0}}), good}},
      {"loop of points", {polygon({{1, 0}, {1, 0}, {1, 0}}), good}},
      {"loop clockwise", {polygon({{0, 0}, {0, 1}, {1, 1}, {1, 0}}), good}},
      {"loop that runs back on itself", {polygon({{0, 0}, {1, 0}, {1, 1}, {1, 0.5}, {1, 1}, {0, 1}}), good}},
      {"sliver", {polygon({{0, 0}, {1, 0}, {1, 1e-9}, {0, 1e-9}}), good}},
      {"tiny face", {polygon({{1 - 1e-8, 0}, {1, 0}, {1, 1e-8}, {1 - 1e-8, 1e-8}}), good}},
      {"hole across the border", {crossing_hole, good}},
      {"hole outside", {hole_outside, good}},
      {"hole alone", {hole_alone, good}},
      {"no loops", {TrimmedPatch{square, {}, false, "bad"}, good}},
      {"surface that is a line", {test::whole(flat, "bad"), good}},
      {"surface that is a point", {test::whole(point, "bad"), good}},
      {"surface that crosses itself", {test::whole(twisted, "bad"), good}},
      {"the same patch three times", {test::whole(square), test::whole(square), test::whole(square), good}}};
}

TEST(SeamModel, HoldsBadPatchesOrNamesThem) {
  for (const BadPatches& bad : bad_models()) {
    SeamModel model;
    try {
      model = model_of(bad.patches);
    } catch (const Error& error) {
      ADD_FAILURE() << bad.name << ": " << error.what();
      continue;
    }
    EXPECT_TRUE(std::isfinite(model.size));
    for (const float error : model.hierarchy.errors) EXPECT_FALSE(std::isnan(error)) << bad.name;
    SeamTessellation tessellation(model);
    for (const double tolerance : {1e-4, 1e-2, 0.3, 10.0}) {
      const SeamUpdate update = tessellation.update(tolerance);
      EXPECT_FALSE(std::isnan(update.error_bound)) << bad.name;
      const PolygonSoup soup = tessellation.soup();
      validate(soup, bad.name);
      // The good one is there, or it has vanished with a large tolerance.
      if (tolerance < 0.1) {
        EXPECT_EQ(tessellation.triangles_of(bad.patches.size() - 1).triangles.size() > 1, true) << bad.name;
      }
      for (std::size_t patch = 0; patch < model.graph.n_patches(); ++patch) {
        const PatchTriangles& triangles = tessellation.triangles_of(patch);
        const bool is_named =
            std::find(update.refused.begin(), update.refused.end(), patch) != update.refused.end();
        EXPECT_TRUE(is_named || triangles.error_bound <= tolerance) << bad.name << ", patch " << patch;
        // Of what isn't there, the rest is as far as the model is wide: from 0 to 2 along x.
        if (is_named && triangles.triangles.empty()) {
          EXPECT_GE(update.error_bound, 2) << bad.name;
        }
      }
    }
  }
}

TEST(SeamModel, RefusesSurfacesThatAreNotFinite) {
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    std::vector<TrimmedPatch> patches = test::box_faces({1, 1, 1});
    patches[3].surface.points[2].x() = bad;
    EXPECT_THROW(model_of(patches), InputError);
    patches = test::box_faces({1, 1, 1});
    patches[3].loops[0].curves[2].curve.points[0].y() = bad;
    EXPECT_THROW(model_of(patches), InputError);
  }
}

}  // namespace
}  // namespace recede
