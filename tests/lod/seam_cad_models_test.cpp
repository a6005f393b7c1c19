// Levels of what OpenCASCADE makes, and of CAD files of Debian's package occt-misc.
#include "cad_shapes.h"
#include "sanitized.h"
#include "seam_level_checks.h"
#include "temp_folder.h"
#include <recede/geometry/cad_import.h>
#include <recede/geometry/error.h>
#include <recede/lod/seam_model.h>

#include <gtest/gtest.h>

#include <functional>

namespace recede {
namespace {

namespace fs = std::filesystem;

CadModel import_shape(const TopoDS_Shape& shape) {
  const test::TempFolder folder;
  test::write_brep(folder / "shape.brep", shape);
  return read_cad(folder / "shape.brep");
}

// A part and all that its levels need, in one place, as these refer to it.
struct Tested {
  std::string name;
  CadPart part;
  SeamModel model;
  SeamTessellation tessellation;
  test::LevelChecker checker;

  Tested(std::string of, const CadPart& from)
      : name(std::move(of)),
        part(from),
        model(build_seam_model(part)),
        tessellation(model),
        checker(name, part.patches, model) {}
  Tested(const Tested&) = delete;
};

void expect_sound_levels(Tested& tested, int n_random, int n_cameras, std::size_t n_points) {
  const double size = tested.model.size;
  for (double tolerance = 2e-3 * size; tolerance < 2 * size; tolerance *= 2.5) {
    const SeamUpdate update = tested.tessellation.update(tolerance);
    tested.checker.expect_closed(tested.tessellation, update);
    tested.checker.expect_within(tested.tessellation, update, tolerance, n_points);
  }
  std::mt19937 random(51);
  for (int round = 0; round < n_random; ++round) {
    const std::vector<double> tolerances = test::random_tolerances(tested.model, random);
    const SeamUpdate update = tested.tessellation.update(tolerances);
    tested.checker.expect_closed(tested.tessellation, update);
    if (round % 10 == 0) tested.checker.expect_within(tested.tessellation, update, tolerances, n_points);
  }
  for (int round = 0; round < n_cameras; ++round) {
    const std::vector<double> tolerances = test::camera_tolerances(tested.model, random);
    tested.checker.expect_closed(tested.tessellation, tested.tessellation.update(tolerances));
  }
}

struct Shape {
  std::string name;
  std::function<TopoDS_Shape()> make;
};
void PrintTo(const Shape& shape, std::ostream* out) { *out << shape.name; }

class SeamModelOfShape : public testing::TestWithParam<Shape> {};

TEST_P(SeamModelOfShape, IsClosedAndWithinItsBoundsForAnyTolerances) {
  const CadModel cad = import_shape(GetParam().make());
  ASSERT_EQ(cad.parts.size(), 1u);
  ASSERT_TRUE(cad.parts[0].is_closed);
  Tested tested(GetParam().name, cad.parts[0]);
  EXPECT_EQ(tested.model.turned, 0u);
  EXPECT_EQ(tested.model.graph.report.free_edges, 0u);
  expect_sound_levels(tested, test::k_sanitized ? 5 : 50, test::k_sanitized ? 5 : 50, 200);
}

INSTANTIATE_TEST_SUITE_P(All, SeamModelOfShape,
                         testing::Values(Shape{"Box", [] { return test::cad_box(); }},
                                         Shape{"RoundedBox", [] { return test::cad_rounded_box(); }},
                                         Shape{"Can", [] { return test::cad_cylinder(); }},
                                         Shape{"Sphere", [] { return test::cad_sphere(); }},
                                         Shape{"BoredSphere", test::cad_bored_sphere},
                                         Shape{"Torus", [] { return test::cad_torus(); }},
                                         Shape{"Cone", [] { return test::cad_cone(); }},
                                         Shape{"WavyBlock", test::cad_wavy_block},
                                         Shape{"Prism", [] { return test::cad_prism(24); }},
                                         Shape{"Plate", [] { return test::cad_plate(4); }},
                                         Shape{"Screw", test::cad_screw}),
                         [](const auto& tested) { return tested.param.name; });

CadModel read_file(const std::string& name) { return read_cad(fs::path(RECEDE_DATA) / "cad" / name); }

class SeamModelOfFile : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (!fs::exists(RECEDE_DATA "/cad")) GTEST_SKIP() << "no models; ./dev data fetches them";
    if (test::k_sanitized) GTEST_SKIP() << "slow under sanitizers";
  }
};

TEST_P(SeamModelOfFile, IsClosedAndWithinItsBoundsForAnyTolerances) {
  std::size_t n_closed = 0;
  for (const CadPart& part : read_file(GetParam()).parts) {
    if (!part.is_closed) continue;
    Tested tested(GetParam() + ", " + part.name, part);
    expect_sound_levels(tested, 10, 10, 50);
    ++n_closed;
  }
  EXPECT_GT(n_closed, 0u);
}

// Bounds are proved; 10 000 points of every face confirm them.
void expect_faces_within(const CadPart& part, const std::string& name, double share, std::size_t n_points) {
  const SeamModel model = build_seam_model(part);
  SeamTessellation tessellation(model);
  const double tolerance = share * model.size;
  const SeamUpdate update = tessellation.update(tolerance);
  EXPECT_TRUE(update.refused.empty()) << name;
  std::mt19937 random(91);
  for (std::size_t patch = 0; patch < part.patches.size(); ++patch) {
    const PatchTriangles& triangles = tessellation.triangles_of(patch);
    if (triangles.triangles.empty()) continue;  // vanished
    const PatchSurface& surface = model.surfaces[patch];
    const test::TrimmedRegion region(part.patches[patch], surface, 64);
    const ClosestPointTree tree = test::tree_of(triangles);
    std::size_t n = 0;
    double largest = 0;
    // A region may be a small part of its box.
    for (int round = 0; round < 500 && n < n_points; ++round) {
      for (const Vec2& uv : region.places(n_points - n, random)) {
        largest = std::max(largest, tree.closest(surface.shape.evaluate(uv)).squared_distance);
        ++n;
      }
    }
    EXPECT_EQ(n, n_points) << name << ", patch " << patch;
    EXPECT_LE(std::sqrt(largest),
              std::min(tolerance, triangles.error_bound) + region.slack_of_inside() + 1e-12 * model.size)
        << name << ", patch " << patch;
    // So that the comparison says something.
    EXPECT_LE(region.slack_of_inside(), 0.1 * tolerance) << name << ", patch " << patch;
  }
}

TEST(SeamModelOfShapes, IsWithinItsToleranceAtTenThousandPointsOfEveryFace) {
  const std::vector<Shape> shapes{{"rounded box", [] { return test::cad_rounded_box(); }},
                                  {"bored sphere", test::cad_bored_sphere},
                                  {"torus", [] { return test::cad_torus(); }},
                                  {"cone", [] { return test::cad_cone(); }},
                                  {"wavy block", test::cad_wavy_block},
                                  {"offset", test::cad_offset_face}};
  for (const Shape& shape : shapes) {
    for (const CadPart& part : import_shape(shape.make()).parts)
      expect_faces_within(part, shape.name, 1e-3, test::k_sanitized ? 100 : 10'000);
  }
}

TEST_P(SeamModelOfFile, IsWithinItsToleranceAtTenThousandPointsOfEveryFace) {
  for (const CadPart& part : read_file(GetParam()).parts) expect_faces_within(part, GetParam(), 1e-3, 10'000);
}

INSTANTIATE_TEST_SUITE_P(All, SeamModelOfFile,
                         testing::Values("occ/bottle.brep", "step/linkrods.step", "step/screw.step"),
                         [](const auto& tested) {
                           std::string name = fs::path(tested.param).stem().string();
                           return name;
                         });

using SeamModelOfFineTriangles = SeamModelOfFile;

TEST_F(SeamModelOfFineTriangles, HasNoneTurnedOverBesideBordersThatAreCoarser) {
  for (const char* name : {"occ/bottle.brep", "step/screw.step"}) {
    for (const CadPart& part : read_file(name).parts) {
      const SeamModel model = build_seam_model(part);
      const double seams = model.graph.tolerance;
      SeamTessellation tessellation(model);
      for (const double tolerance : {0.075 * seams, 0.3 * seams, seams}) {
        const SeamUpdate update = tessellation.update(tolerance);
        EXPECT_EQ(update.inverted, 0u) << name << ", " << tolerance / seams;
        if (tolerance < 0.1 * seams) {
          EXPECT_FALSE(update.refused.empty()) << name;
        }
        for (std::size_t patch = 0; patch < part.patches.size(); ++patch) {
          const bool is_refused = std::count(update.refused.begin(), update.refused.end(), patch) > 0;
          // Four times the seams' error is as coarse as it gets.
          EXPECT_LE(tessellation.triangles_of(patch).error_bound, is_refused ? 4 * seams : tolerance);
        }
        EXPECT_TRUE(test::open_sides(tessellation.soup()).empty());
        // What was found to be reached isn't tried again.
        const SeamUpdate again = tessellation.update(tolerance);
        EXPECT_EQ(again.tessellated + again.moves.splits + again.moves.merges, 0u);
        EXPECT_EQ(again.refused, update.refused);
        EXPECT_EQ(again.error_bound, update.error_bound);
      }
    }
  }
}

using SeamModelOfIges = SeamModelOfFile;

TEST_F(SeamModelOfIges, TurnsPatchesOfAFileThatKnowsNothingOfThem) {
  const CadModel cad = read_file("iges/hammer.iges");
  for (const CadPart& part : cad.parts) {
    const SeamModel model = build_seam_model(part);
    EXPECT_EQ(model.graph.report.edges_of_file, 0u);
    EXPECT_GT(model.graph.report.edges_by_position, 0u);
    // Two patches at a side run along it in opposite directions once they have turned.
    SeamTessellation tessellation(model);
    tessellation.update(1e-3 * model.size);
    std::size_t n_against = 0;
    for (const auto& [side, times] : test::open_sides(tessellation.soup())) n_against += std::abs(times) > 1;
    EXPECT_EQ(n_against, 0u);
  }
}

TEST_F(SeamModelOfIges, ListsGapsWhereNothingIsSewn) {
  std::size_t n_gaps = 0;
  for (const CadPart& part : read_file("iges/bearing.iges").parts) {
    const std::vector<PatchSurface> surfaces = prepare_surfaces(part.patches);
    SeamGraphOptions options;
    options.gap = 1e-12;
    options.use_connectivity = false;
    const SeamGraph graph = build_seam_graph(part.patches, surfaces, options);
    for (const SeamGap& gap : graph.report.gaps) {
      EXPECT_LT(gap.patch, part.patches.size());
      EXPECT_LT(gap.other, part.patches.size());
      EXPECT_GE(gap.distance, 0);
      EXPECT_TRUE(gap.point.allFinite());
    }
    n_gaps += graph.report.gaps.size();
  }
  EXPECT_GT(n_gaps, 0u);
}

// Faces that can't be used as they are, as far as they come through import.
TEST(SeamModelOfBadShapes, HoldsThemOrNamesThem) {
  const std::vector<Shape> shapes{{"open loop", test::cad_open_loop},
                                  {"no area", test::cad_face_without_area},
                                  {"crossing loop", test::cad_crossing_loop},
                                  {"wrong way", test::cad_loop_the_wrong_way},
                                  {"endless plane", test::cad_endless_plane},
                                  {"wire of one vertex", test::cad_wire_of_one_vertex},
                                  {"three faces at an edge", test::cad_three_faces_at_an_edge},
                                  {"duplicate faces", test::cad_duplicate_faces},
                                  {"tube without seam", test::cad_tube_without_seam},
                                  {"slit", test::cad_square_with_inner_edge},
                                  {"two islands", test::cad_two_islands},
                                  {"shifted patch", test::cad_shifted_patch},
                                  {"periodic patch", test::cad_periodic_patch},
                                  {"offset", test::cad_offset_face}};
  std::size_t n_refused = 0;
  for (const Shape& shape : shapes) {
    CadModel cad;
    try {
      cad = import_shape(test::cad_compound({shape.make(), test::cad_box()}));
    } catch (const InputError&) {
      ++n_refused;
      continue;
    }
    for (const CadPart& part : cad.parts) {
      const SeamModel model = build_seam_model(part);
      SeamTessellation tessellation(model);
      for (const double tolerance : {1e-3, 0.1, 5.0, 100.0}) {  // the first is finer than seams are
        const SeamUpdate update = tessellation.update(tolerance);
        EXPECT_TRUE(std::isfinite(update.error_bound)) << shape.name;
        EXPECT_TRUE(!update.refused.empty() || update.error_bound <= tolerance) << shape.name;
        for (const Vec3& point : tessellation.soup().positions) EXPECT_TRUE(point.allFinite()) << shape.name;
      }
    }
  }
  EXPECT_LT(n_refused, shapes.size() / 2);
}

}  // namespace
}  // namespace recede
