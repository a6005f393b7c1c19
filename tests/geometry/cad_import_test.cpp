// CAD files: assemblies, units, and what is wrong with some of them.
#include "cad_checks.h"
#include "error_text.h"

#include <gmock/gmock.h>

namespace recede::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// The same bits, field by field.
void expect_same(const CadModel& a, const CadModel& b) {
  ASSERT_EQ(a.parts.size(), b.parts.size());
  for (std::size_t i = 0; i < a.parts.size(); ++i) {
    ASSERT_EQ(a.parts[i].patches.size(), b.parts[i].patches.size());
    EXPECT_EQ(a.parts[i].n_edges, b.parts[i].n_edges);
    for (std::size_t j = 0; j < a.parts[i].patches.size(); ++j) {
      const TrimmedPatch &p = a.parts[i].patches[j], &q = b.parts[i].patches[j];
      EXPECT_EQ(p.surface.points, q.surface.points);
      EXPECT_EQ(p.surface.weights, q.surface.weights);
      EXPECT_EQ(p.surface.knots, q.surface.knots);
      ASSERT_EQ(p.loops.size(), q.loops.size());
      for (std::size_t k = 0; k < p.loops.size(); ++k) {
        ASSERT_EQ(p.loops[k].curves.size(), q.loops[k].curves.size());
        for (std::size_t c = 0; c < p.loops[k].curves.size(); ++c) {
          EXPECT_EQ(p.loops[k].curves[c].curve.points, q.loops[k].curves[c].curve.points);
          EXPECT_EQ(p.loops[k].curves[c].edge, q.loops[k].curves[c].edge);
        }
      }
    }
  }
  EXPECT_EQ(list(a), list(b));
}

TEST(CadImport, TellsFilesByTheEndsOfTheirNames) {
  EXPECT_TRUE(can_read_cad());
  for (const char* name : {"a.step", "b.STP", "c.iges", "d.IGS", "e.brep", "f.brp"}) {
    EXPECT_TRUE(is_cad_path(name)) << name;
  }
  for (const char* name : {"a.stl", "step", "b.step.gz", ""}) EXPECT_FALSE(is_cad_path(name)) << name;
}

TEST(CadImport, ReadsTheSameFromStepIgesAndBrep) {
  const TempFolder folder;
  const TopoDS_Shape shape = cad_plate(2);
  write_step(folder / "plate.step", shape);
  write_iges(folder / "plate.iges", shape);
  write_brep(folder / "plate.brep", shape);
  for (const char* name : {"plate.step", "plate.iges", "plate.brep"}) {
    const CadModel model = read_cad(folder / name);
    expect_well_formed(model);
    ASSERT_EQ(model.parts.size(), 1u) << name;
    EXPECT_EQ(model.parts[0].patches.size(), 10u) << name;
    // 12 of the block; two rims and a seam for each hole.
    EXPECT_EQ(model.parts[0].n_edges, 24u) << name;
    EXPECT_TRUE(model.parts[0].is_closed) << name;
    EXPECT_EQ(model.metres_per_unit, 1e-3);
  }
}

TEST(CadImport, GivesTheSameTwice) {
  const TempFolder folder;
  write_step_assembly(folder / "twice.step", cad_screws_on_plates(200));
  expect_same(read_cad(folder / "twice.step"), read_cad(folder / "twice.step"));
}

TEST(CadImport, KeepsInstancesNamesAndColours) {
  const TempFolder folder;
  const TopoDS_Shape screw = cad_screw(), plate = cad_plate(2);
  write_step_assembly(folder / "assembly.step",
                      {{plate, "plate", {0, 0, 0}, {0.2, 0.3, 0.8}},
                       {screw, "screw", {4, 4, 0}, {-1, 0, 0}},
                       {screw, "screw", {12, 4, 0}, {-1, 0, 0}}},
                      {screw});
  const CadModel model = read_cad(folder / "assembly.step");
  expect_well_formed(model);
  ASSERT_EQ(model.parts.size(), 2u);
  EXPECT_EQ(model.parts[0].name, "plate");
  EXPECT_EQ(model.parts[1].name, "screw");
  ASSERT_EQ(model.instances.size(), 3u);
  EXPECT_EQ(model.instances[0].name, "plate");
  EXPECT_EQ(model.instances[1].part, model.instances[2].part);
  const Vec3 place = model.instances[2].placement * Vec3(0, 0, 0);
  EXPECT_NEAR((place - Vec3(12, 4, 0)).norm(), 0, 1e-12);

  ASSERT_NE(model.instances[0].material, k_no_index);
  const Vec4& blue = model.materials[model.instances[0].material].base_color;
  // Files of colours may hold floats.
  EXPECT_NEAR((blue - Vec4(0.2, 0.3, 0.8, 1)).norm(), 0, 1e-5);
  EXPECT_EQ(model.instances[1].material, k_no_index);
  std::size_t red = 0;
  for (const TrimmedPatch& patch : model.parts[1].patches) {
    if (patch.material == k_no_index) continue;
    ++red;
    EXPECT_NEAR((model.materials[patch.material].base_color - Vec4(1, 0, 0, 1)).norm(), 0, 1e-5);
  }
  EXPECT_EQ(red, 1u);
}

TEST(CadImport, KeepsThousandsOfPatchesInTwoParts) {
  const TempFolder folder;
  write_step_assembly(folder / "many.step", cad_screws_on_plates(5000));
  const CadModel model = read_cad(folder / "many.step");
  ASSERT_EQ(model.parts.size(), 2u);
  EXPECT_TRUE(model.parts[0].is_closed);
  EXPECT_TRUE(model.parts[1].is_closed);
  std::size_t placed = 0;
  for (const CadInstance& instance : model.instances) placed += model.parts[instance.part].patches.size();
  EXPECT_GE(placed, 5000u);
  EXPECT_EQ(list(model), "");
}

TEST(CadImport, TheSameBodyAtTwoPlacesOfABrepFileIsOnePart) {
  gp_Trsf move;
  move.SetTranslation(gp_Vec(0, 0, 50));
  const TopoDS_Shape box = cad_box();
  const CadModel model = import_shape(cad_compound({box, box.Moved(TopLoc_Location(move))}));
  ASSERT_EQ(model.parts.size(), 1u);
  ASSERT_EQ(model.instances.size(), 2u);
  EXPECT_EQ(model.instances[1].placement.translation(), Vec3(0, 0, 50));
}

TEST(CadImport, ReadsMillimetresWhateverTheUnit) {
  const TempFolder folder;
  for (const char* unit : {"KM", "M", "INCH", "UM"}) {
    write_step(folder / "unit.step", cad_box(30, 20, 10), unit);
    const CadModel model = read_cad(folder / "unit.step");
    ASSERT_EQ(model.parts.size(), 1u) << unit;
    Box3 box;
    for (const TrimmedPatch& patch : model.parts[0].patches) {
      for (const Vec3& point : patch.surface.points) box.extend(point);
    }
    // Decimal numbers in the file have 15 digits.
    EXPECT_NEAR((box.sizes() - Vec3(30, 20, 10)).norm(), 0, 1e-9) << unit;
  }
}

TEST(CadImport, BodiesOfAKilometreAndOfAMicrometreAreExact) {
  for (const double size : {1e6, 1e-3}) {
    const TopoDS_Shape shape = cad_cylinder(size, 2 * size);
    const CadModel model = import_shape(shape);
    expect_well_formed(model);
    EXPECT_TRUE(model.parts[0].is_closed);
    EXPECT_LT(largest_gap(model.parts[0]), 1e-12 * size);
  }
}

TEST(CadImport, ThreeFacesAtAnEdgeAreKeptAndOpen) {
  const CadModel model = import_shape(cad_three_faces_at_an_edge());
  expect_well_formed(model);
  ASSERT_EQ(model.parts.size(), 1u);
  EXPECT_EQ(model.parts[0].patches.size(), 3u);
  EXPECT_EQ(model.parts[0].n_edges, 10u);
  EXPECT_FALSE(model.parts[0].is_closed);
}

TEST(CadImport, DuplicateFacesAreTwoPatches) {
  const CadModel model = import_shape(cad_duplicate_faces());
  EXPECT_EQ(count_patches(model), 2u);
  EXPECT_EQ(model.parts[0].n_edges, 8u);
}

TEST(CadImport, AFaceMayHaveTwoOuterLoops) {
  const CadModel model = import_shape(cad_two_islands());
  expect_well_formed(model);
  ASSERT_EQ(model.parts[0].patches[0].loops.size(), 2u);
  EXPECT_EQ(list(model), "");
}

TEST(CadImport, ATubeGetsTheSeamThatItLacks) {
  const TopoDS_Shape shape = cad_tube_without_seam();
  const CadModel model = import_shape(shape);
  expect_well_formed(model);
  EXPECT_THAT(list(model), HasSubstr("face 1 of \"shape\": mended, because a loop doesn't close"));
  const TrimmedPatch& patch = model.parts[0].patches[0];
  ASSERT_EQ(patch.loops.size(), 1u);
  EXPECT_EQ(patch.loops[0].curves.size(), 4u);
  EXPECT_EQ(model.parts[0].n_edges, 3u);
  EXPECT_THAT(error_text([&] { import_shape(shape, {.repair = false}); }), HasSubstr("a loop doesn't close"));
}

TEST(CadImport, ALoopTheWrongWayAroundIsTurned) {
  const CadModel model = import_shape(cad_loop_the_wrong_way());
  expect_well_formed(model);
  EXPECT_THAT(list(model), HasSubstr("mended, because a loop runs the wrong way around"));
  EXPECT_EQ(model.parts[0].patches[0].loops.size(), 1u);
}

TEST(CadImport, WhatBoundsNothingIsLeftOutByName) {
  const CadModel inner = import_shape(cad_square_with_inner_edge());
  expect_well_formed(inner);
  EXPECT_THAT(list(inner), HasSubstr("face 1 of \"shape\": 1 edges inside of it bound nothing"));
  const CadModel vertex = import_shape(cad_wire_of_one_vertex());
  expect_well_formed(vertex);
  EXPECT_THAT(list(vertex), HasSubstr("face 1 of \"shape\": 1 of its edges are points"));
}

struct BadFace {
  const char* name;
  TopoDS_Shape (*make)();
  const char* reason;
  friend std::ostream& operator<<(std::ostream& out, const BadFace& face) { return out << face.name; }
};

class UnusableCadFace : public testing::TestWithParam<BadFace> {};
INSTANTIATE_TEST_SUITE_P(
    CadImport, UnusableCadFace,
    testing::Values(BadFace{"LoopThatDoesntClose", cad_open_loop, "a loop doesn't close"},
                    BadFace{"NoArea", cad_face_without_area, "it has no area"},
                    BadFace{"LoopThatCrossesItself", cad_crossing_loop, "its loops cross"},
                    BadFace{"HoleAcrossTheBorder", cad_hole_across_the_border, "its loops cross"},
                    BadFace{"HoleOutside", cad_hole_outside, "a loop runs the wrong way around"},
                    BadFace{"SurfaceThatIsALine", cad_surface_that_is_a_line, "it has no area"},
                    BadFace{"SurfaceThatIsAPoint", cad_surface_that_is_a_point, "it has no area"},
                    BadFace{"EdgeWithoutCurve", cad_edge_without_curve, "an edge has no curve on it"},
                    BadFace{"WithoutSurface", cad_face_without_surface, "it has no surface"},
                    BadFace{"PlaneWithoutBounds", cad_endless_plane, "nothing bounds it"}),
    [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(UnusableCadFace, IsNamedAndTheOthersStay) {
  const CadImportOptions as_it_is{.repair = false};
  const CadModel model = import_shape(cad_compound({GetParam().make(), cad_two_islands()}), as_it_is);
  expect_well_formed(model);
  EXPECT_EQ(count_patches(model), 1u);
  ASSERT_EQ(model.left_out.size(), 1u);
  EXPECT_EQ(model.left_out[0].entity, "face 1 of \"shape\"");
  EXPECT_THAT(model.left_out[0].reason, HasSubstr(GetParam().reason));
  EXPECT_FALSE(model.parts[0].is_closed);
  // Alone it leaves nothing to read.
  EXPECT_THAT(error_text([&] { import_shape(GetParam().make(), as_it_is); }),
              AllOf(HasSubstr("shape.brep: holds no face that can be used"), HasSubstr(GetParam().reason)));
}

/// Whatever OpenCASCADE makes of them: never silently, and never malformed.
TEST_P(UnusableCadFace, IsMendedOrLeftOutWhenRepairsAreAllowed) {
  const CadModel model = import_shape(cad_compound({GetParam().make(), cad_two_islands()}));
  expect_well_formed(model);
  EXPECT_GE(count_patches(model), 1u);
  EXPECT_THAT(list(model), AllOf(HasSubstr("face 1 of \"shape\""), HasSubstr(GetParam().reason)));
}

std::string import_error(const TempFolder& folder, std::string_view name, std::string_view content) {
  const std::filesystem::path path = folder.write(name, content);
  const std::string text = error_text([&] { read_cad(path); });
  EXPECT_EQ(text.find('\n'), text.npos) << text;
  return text;
}

TEST(CadImport, RefusesFilesThatAreCutShort) {
  const TempFolder folder;
  write_step(folder / "whole.step", cad_plate(2));
  write_iges(folder / "whole.iges", cad_plate(2));
  write_brep(folder / "whole.brep", cad_plate(2));
  for (const char* extension : {".step", ".iges", ".brep"}) {
    const std::string whole = read_whole_file(folder / ("whole" + std::string(extension)));
    const std::string name = "cut" + std::string(extension);
    for (const double share : {0.2, 0.5, 0.9, 0.99}) {
      const auto length = static_cast<std::size_t>(share * static_cast<double>(whole.size()));
      EXPECT_THAT(import_error(folder, name, whole.substr(0, length)), HasSubstr("is cut short"))
          << name << " " << share;
    }
  }
}

/// OpenCASCADE alone reads for ever where one of these numbers isn't one.
TEST(CadImport, EndsOnBrepFilesWithLettersForNumbers) {
  const TempFolder folder;
  write_brep(folder / "whole.brep", cad_plate(1));
  const std::string whole = read_whole_file(folder / "whole.brep");
  std::size_t refused = 0;
  for (std::size_t at = whole.find("Curve2ds"); at + 1 < whole.size(); at += 37) {
    std::string damaged = whole;
    damaged[at] = ')';
    const std::filesystem::path path = folder.write("damaged.brep", damaged);
    try {
      expect_well_formed(read_cad(path));
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("damaged.brep: "));
      ++refused;
    }
  }
  EXPECT_GT(refused, 10u);
}

TEST(CadImport, RefusesTextThatIsSomethingElse) {
  const TempFolder folder;
  const std::string text = "solid of words\nand no numbers\n";
  EXPECT_THAT(import_error(folder, "a.step", text), HasSubstr("a.step: isn't a STEP file"));
  EXPECT_THAT(import_error(folder, "a.iges", text), HasSubstr("a.iges: isn't an IGES file"));
  EXPECT_THAT(import_error(folder, "a.brep", text), HasSubstr("a.brep: isn't a BREP file"));
  EXPECT_THAT(import_error(folder, "a.step", ""), HasSubstr("isn't a STEP file"));
  EXPECT_THAT(error_text([&] { read_cad(folder / "absent.step"); }), HasSubstr("absent.step"));
  EXPECT_THAT(import_error(folder, "a.obj", text), HasSubstr("unknown kind of CAD file"));
}

/// The frame of a STEP file around nothing, and around nonsense.
TEST(CadImport, RefusesStepFilesWithoutAShape) {
  const TempFolder folder;
  const std::string head =
      "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
      "FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n";
  const std::string tail = "ENDSEC;\nEND-ISO-10303-21;\n";
  EXPECT_NE(import_error(folder, "empty.step", head + tail), "");
  EXPECT_NE(import_error(folder, "nonsense.step", head + "#1=NONSENSE(#2,#1);\n#2=))(;\n" + tail), "");
}

TEST(CadImport, RefusesAnEmptyAssembly) {
  const TempFolder folder;
  write_step_assembly(folder / "empty.step", {});
  EXPECT_NE(error_text([&] { read_cad(folder / "empty.step"); }), "");
}

TEST(CadImport, PrintsNothing) {
  const TempFolder folder;
  write_step(folder / "quiet.step", cad_box());
  write_iges(folder / "quiet.iges", cad_box());
  testing::internal::CaptureStdout();
  for (const char* name : {"quiet.step", "quiet.iges"}) read_cad(folder / name);
  import_error(folder, "loud.step", "ISO-10303-21;\nDATA;\n#1=);\nENDSEC;\nEND-ISO-10303-21;\n");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

class StopsAtOnce final : public Progress {
 public:
  void update(std::string_view, double) override {}
  bool cancel_requested() const override { return true; }
};

TEST(CadImport, StopsWhenAsked) {
  const TempFolder folder;
  write_step(folder / "box.step", cad_box());
  StopsAtOnce progress;
  EXPECT_THROW(read_cad(folder / "box.step", {}, &progress), Cancelled);
}

class Fractions final : public Progress {
 public:
  void update(std::string_view stage, double fraction) override {
    EXPECT_TRUE(0 <= fraction && fraction <= 1) << stage << fraction;
    if (stage == "convert") last = fraction;
  }
  double last = 0;
};

TEST(CadImport, SaysHowFarItIs) {
  const TempFolder folder;
  write_step(folder / "box.step", cad_box());
  Fractions progress;
  read_cad(folder / "box.step", {}, &progress);
  EXPECT_EQ(progress.last, 1);
}

}  // namespace
}  // namespace recede::test
