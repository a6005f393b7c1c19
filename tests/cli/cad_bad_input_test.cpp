// CAD files with faces that can't be used: commands name them, and do the rest.
#include "cad_shapes.h"
#include "run_recede.h"

namespace recede::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

struct BadFace {
  const char* name;
  TopoDS_Shape (*make)();
  const char* reason;
  friend std::ostream& operator<<(std::ostream& out, const BadFace& face) { return out << face.name; }
};

class BadCadFile : public testing::TestWithParam<BadFace> {};
INSTANTIATE_TEST_SUITE_P(
    All, BadCadFile,
    testing::Values(BadFace{"LoopThatDoesntClose", cad_open_loop, "a loop doesn't close"},
                    BadFace{"LoopThatCrossesItself", cad_crossing_loop, "its loops cross"},
                    BadFace{"HoleAcrossTheBorder", cad_hole_across_the_border, "its loops cross"},
                    BadFace{"NoArea", cad_face_without_area, "it has no area"},
                    BadFace{"SurfaceThatIsALine", cad_surface_that_is_a_line, "it has no area"},
                    BadFace{"WithoutSurface", cad_face_without_surface, "it has no surface"}),
    [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(BadCadFile, IsNamedByEveryCommandThatDoesTheRest) {
  const TempFolder folder;
  const std::string file = folder / "bad.brep";
  write_brep(file, cad_compound({GetParam().make(), cad_box()}));
  const auto expect_named = [&](const json& result, const CommandResult& run) {
    // What was mended instead says so.
    const std::string told = result["left_out"].dump() + result["repairs"].dump();
    EXPECT_THAT(told, HasSubstr(GetParam().reason));
    EXPECT_THAT(told, HasSubstr("face 1 of"));
    if (result["command"] != "info") {
      EXPECT_THAT(run.remarks, HasSubstr(GetParam().reason));
    }
  };
  const CommandResult info = run_recede({"info", file, "--json"});
  expect_named(json_of(info), info);
  const CommandResult bake = run_recede(
      {"bake", file, "-o", folder / "out", "--relative-errors", "0.001", "0.1", "--no-report", "--json"});
  expect_named(json_of(bake), bake);
  const json level = json_of(bake)["levels"][0];
  EXPECT_GE(level["faces"].get<int>(), 12);  // the box
  EXPECT_TRUE(level["missed"].empty());
  const CommandResult seams = run_recede({"seams", file, "--json"});
  expect_named(json_of(seams), seams);
  const CommandResult walk = run_recede({"walk", file, "--frames", "2"});
  EXPECT_EQ(walk.code, 0);
  EXPECT_THAT(walk.remarks, HasSubstr(GetParam().reason));
}

TEST(BadCadInput, AStepFileWithoutOneEntityIsBakedWithoutTheFaceThatNeedsIt) {
  const TempFolder folder;
  write_step(folder / "whole.step", cad_plate(1));
  std::string text = read_whole_file(folder / "whole.step");
  const std::size_t at = text.find("= PLANE("), begin = text.rfind('#', at);
  const std::string number = text.substr(begin, text.find(' ', begin) - begin);
  text.erase(begin, text.find(';', at) + 1 - begin);
  const CommandResult bake =
      run_recede({"bake", folder.write("bad.step", text), "-o", folder / "out", "--no-report", "--json"});
  const json result = json_of(bake);
  EXPECT_EQ(result["patches"], 6);
  ASSERT_EQ(result["left_out"].size(), 2u);
  EXPECT_EQ(result["left_out"][0]["entity"], number);
  EXPECT_THAT(bake.remarks, HasSubstr("left out: " + number + ": isn't in the file"));
}

TEST(BadCadInput, BodiesOfAKilometreAndOfAMicrometreAreBakedAlike) {
  std::vector<int> faces;
  for (const double size : {1e6, 1.0, 1e-3}) {
    const TempFolder folder;
    write_step(folder / "can.step", cad_cylinder(size, 2 * size));
    const json result =
        json_of(run_recede({"bake", folder / "can.step", "-o", folder / "out", "--no-report", "--json"}));
    EXPECT_TRUE(result["left_out"].empty()) << size;
    for (const json& level : result["levels"]) {
      EXPECT_TRUE(level["missed"].empty()) << size;
      const json info = json_of(run_recede({"info", level["file"].get<std::string>(), "--json"}));
      EXPECT_EQ(info["border_edges"], 0) << size;
    }
    faces.push_back(result["levels"][0]["faces"].get<int>());
  }
  // But for rounding, the same triangles.
  EXPECT_NEAR(faces[0], faces[1], 0.05 * faces[1]);
  EXPECT_NEAR(faces[2], faces[1], 0.05 * faces[1]);
}

TEST(BadCadInput, AnEmptyAssemblyIsRefusedInOneLine) {
  const TempFolder folder;
  write_step_assembly(folder / "empty.step", {});
  for (const char* command : {"info", "seams"}) {
    EXPECT_THAT(complaint_of(run_recede({command, folder / "empty.step"}), 1),
                HasSubstr("empty.step: holds no face that can be used"));
  }
  EXPECT_THAT(complaint_of(run_recede({"bake", folder / "empty.step", "-o", folder / "out"}), 1),
              HasSubstr("empty.step: holds no face that can be used"));
  EXPECT_FALSE(fs::exists(folder / "out"));
}

}  // namespace
}  // namespace recede::test
