// `recede bake` and `recede seams` of CAD files.
#include "cad_inputs.h"
#include "run_recede.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <sstream>

namespace recede::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

/// What the command says of a level's file.
json info_of(const json& level) {
  return json_of(run_recede({"info", level["file"].get<std::string>(), "--json"}));
}

std::string write_rounded_box(const TempFolder& folder) {
  write_step(folder / "box.step", cad_rounded_box());
  return folder / "box.step";
}

TEST(CadBake, WritesClosedLevelsWithErrorsAndFewerAndFewerPatches) {
  const TempFolder folder;
  const json result =
      json_of(run_recede({"bake", write_rounded_box(folder), "-o", folder / "out", "--relative-errors",
                          "0.001", "0.01", "0.3", "--no-report", "--json"}));
  EXPECT_EQ(result["patches"], 26);
  ASSERT_EQ(result["levels"].size(), 3u);
  const double diagonal = result["diagonal"].get<double>();
  std::size_t faces = 1'000'000, patches = 26;
  const double shares[] = {0.001, 0.01, 0.3};
  for (std::size_t i = 0; i < 3; ++i) {
    const json& level = result["levels"][i];
    EXPECT_LE(level["error"]["bound"].get<double>(), shares[i] * diagonal) << i;
    EXPECT_GT(level["error"]["bound"].get<double>(), 0) << i;
    EXPECT_TRUE(level["missed"].empty()) << level["missed"];
    EXPECT_LT(level["faces"].get<std::size_t>(), faces) << i;
    EXPECT_LE(level["patches"].get<std::size_t>(), patches) << i;
    faces = level["faces"].get<std::size_t>();
    patches = level["patches"].get<std::size_t>();
    EXPECT_EQ(info_of(level)["border_edges"], 0) << i;
  }
  EXPECT_LT(patches, 26u);
  EXPECT_EQ(result["parts"][0]["edges_of_file"], 48);
}

TEST(CadBake, PutsPartsWhereTheirInstancesAre) {
  const TempFolder folder;
  const json result = json_of(run_recede(
      {"bake", write_plate_with_screws(folder), "-o", folder / "out", "--errors", "0.05", "0.5", "--json"}));
  EXPECT_EQ(result["instances"], 3);
  EXPECT_EQ(result["patches"], 22);
  EXPECT_EQ(result["parts"].size(), 2u);
  const json report = json::parse(read_whole_file(folder / "out/report.json"));
  EXPECT_EQ(report["levels"][0]["patches"], 22);
  const json level = info_of(result["levels"][0]);
  EXPECT_EQ(level["materials"].size(), 2u);
  EXPECT_EQ(level["corner_normals"], true);
  // The GLB has two parts on each level, and says where three of them are.
  const std::string glb = result["hierarchy"];
  const json document = json_of_glb(glb);
  EXPECT_EQ(document["meshes"].size(), 4u);
  std::vector<std::string> names;
  for (const json& node : document["nodes"]) names.push_back(node["name"]);
  EXPECT_THAT(names, testing::ElementsAre("assembly level 0", "plate", "screw", "screw", "assembly level 1",
                                          "plate", "screw", "screw"));
  const json whole = json_of(run_recede({"info", glb, "--json"}));
  EXPECT_EQ(whole["faces"], level["faces"]);
  EXPECT_EQ(whole["border_edges"], 0);
  EXPECT_EQ(whole["materials"].size(), 2u);
  if (!has_gltf_validator()) GTEST_SKIP() << "the glTF validator isn't installed; ./dev test fetches it";
  EXPECT_TRUE(is_valid_gltf(glb));
}

TEST(CadBake, WritesAGlbForEachLevelWhenAsked) {
  const TempFolder folder;
  const json result =
      json_of(run_recede({"bake", write_rounded_box(folder), "-o", folder / "out", "--relative-errors",
                          "0.01", "0.1", "--glb-per-level", "--no-report", "--json"}));
  ASSERT_EQ(result["levels"].size(), 2u);
  for (const json& level : result["levels"])
    EXPECT_EQ(json_of(run_recede({"info", level["glb"].get<std::string>(), "--json"}))["faces"],
              level["faces"]);
}

TEST(CadBake, SaysInTextThatLengthsAreMillimetres) {
  const TempFolder folder;
  const CommandResult run = run_recede(
      {"bake", write_rounded_box(folder), "-o", folder / "out", "--relative-errors", "0.01", "--no-report"});
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.output,
              AllOf(HasSubstr("Errors and distances are millimetres;"),
                    HasSubstr("seams      48 of the file, 0 found by position, 0 free edges, 0 gaps")));
}

TEST(CadBake, RefusesWhatHasNoMeaningForCadFiles) {
  const TempFolder folder;
  const std::string box = write_rounded_box(folder), out = folder / "out";
  EXPECT_THAT(complaint_of(run_recede({"bake", box, "-o", out, "--ratios", "0.5"}), 2),
              HasSubstr("--ratios"));
  EXPECT_THAT(complaint_of(run_recede({"bake", box, "-o", out, "--maps", "normal"}), 2), HasSubstr("--maps"));
  EXPECT_THAT(complaint_of(run_recede({"bake", box, "-o", out, "--placement", "optimal"}), 2),
              HasSubstr("--placement"));
  EXPECT_THAT(complaint_of(run_recede({"bake", "sphere", "-o", out, "--gap", "1"}), 2), HasSubstr("--gap"));
  EXPECT_THAT(complaint_of(run_recede({"bake", box, "-o", out, "--errors", "2", "1"}), 2),
              HasSubstr("increase"));
  folder.write("cut.step", read_whole_file(box).substr(0, 3000));
  EXPECT_THAT(complaint_of(run_recede({"bake", folder / "cut.step", "-o", out}), 1), HasSubstr("cut.step"));
  EXPECT_FALSE(fs::exists(out));
}

TEST(Seams, SayWhatMeetsAndWhatIsLeft) {
  const TempFolder folder;
  const std::string box = write_rounded_box(folder);
  const json result = json_of(run_recede({"seams", box, "-o", folder / "seams.obj", "--json"}));
  const json& part = result["parts"][0];
  EXPECT_EQ(part["patches"], 26);
  EXPECT_EQ(part["edges_of_file"], 48);
  EXPECT_EQ(part["free_edges"], 0);
  EXPECT_TRUE(part["gaps"].empty());
  EXPECT_LT(part["levels"][0]["patches"].get<int>(), 26);
  EXPECT_EQ(part["levels"].back()["patches"], 26);
  const std::string lines = read_whole_file(folder / "seams.obj");
  EXPECT_THAT(lines, AllOf(HasSubstr("\nl "), HasSubstr("\ng ")));
  // The same without what the file knows.
  const json by_position = json_of(run_recede({"seams", box, "--no-connectivity", "--json"}));
  EXPECT_EQ(by_position["parts"][0]["edges_by_position"], 48);
  EXPECT_EQ(by_position["parts"][0]["edges_of_file"], 0);
}

TEST(Seams, NumberThePointsOfAllPartsOneAfterAnother) {
  const TempFolder folder;
  const json result =
      json_of(run_recede({"seams", write_plate_with_screws(folder), "-o", folder / "seams.obj", "--json"}));
  std::istringstream lines(read_whole_file(folder / "seams.obj"));
  std::vector<std::set<std::size_t>> used;  // by part
  std::size_t n_points = 0;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "o") used.emplace_back();
    if (kind == "v") ++n_points;
    if (kind == "l") used.back().insert(std::istream_iterator<std::size_t>(words), {});
  }
  ASSERT_EQ(used.size(), 2u);
  const std::size_t of_first = result["parts"][0]["sewing_points"];
  EXPECT_EQ(n_points, of_first + result["parts"][1]["sewing_points"].get<std::size_t>());
  EXPECT_EQ(*used[0].begin(), 1u);
  EXPECT_LE(*used[0].rbegin(), of_first);
  EXPECT_GT(*used[1].begin(), of_first);
  EXPECT_LE(*used[1].rbegin(), n_points);
}

TEST(Seams, PrintErrorsAsPercent) {
  const TempFolder folder;
  const CommandResult run = run_recede({"seams", write_rounded_box(folder)});
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.output, testing::ContainsRegex("error \\(%\\)    patches   points\n       30 "));
}

TEST(Seams, LeaveFewerLinesAtALargerError) {
  const TempFolder folder;
  const std::string box = write_rounded_box(folder), lines = folder / "seams.obj";
  const auto size_at = [&](const char* error) {
    EXPECT_EQ(run_recede({"seams", box, "-o", lines, "--shown-error", error}).code, 0);
    return std::filesystem::file_size(lines);
  };
  EXPECT_LT(size_at("0.5"), size_at("0"));
}

TEST(Seams, RefuseWhatTheyCantWriteAndErrorsOfNothing) {
  const TempFolder folder;
  const std::string box = write_rounded_box(folder);
  EXPECT_THAT(complaint_of(run_recede({"seams", box, "-o", "x.ply"}), 2), HasSubstr(".obj"));
  EXPECT_THAT(complaint_of(run_recede({"seams", box, "--error", "0"}), 2), HasSubstr("above 0"));
}

TEST(Walk, NeedsMoreTrianglesFromFrameToFrame) {
  const TempFolder folder;
  const json result = json_of(
      run_recede({"walk", write_rounded_box(folder), "--frames", "12", "-o", folder / "walk.csv", "--json"}));
  ASSERT_EQ(result["frames"].size(), 12u);
  const json &first = result["frames"].front(), &last = result["frames"].back();
  EXPECT_LT(first["triangles"].get<int>(), last["triangles"].get<int>());
  EXPECT_LE(first["patches"].get<int>(), last["patches"].get<int>());
  EXPECT_GT(first["tolerance"].get<double>(), last["tolerance"].get<double>());
  // A convex solid shows less than it has.
  EXPECT_GT(first["culled"].get<int>(), 0);
  EXPECT_LE(result["largest_pixel_error"].get<double>(), 1 + 1e-9);
  const std::string table = read_whole_file(folder / "walk.csv");
  EXPECT_THAT(table, testing::StartsWith("frame,tolerance,triangles,"));
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 13) << "the names and a line for each frame";
  std::vector<double> times;
  for (const json& frame : result["frames"]) times.push_back(frame["milliseconds"]);
  std::sort(times.begin(), times.end());
  EXPECT_EQ(result["median_milliseconds"], times[6]);
}

TEST(Walk, SeesAPartThatIsElsewhereAsItWouldSeeItHere) {
  const TempFolder folder;
  write_step_assembly(folder / "here.step", {{cad_rounded_box(), "box"}});
  write_step_assembly(folder / "there.step", {{cad_rounded_box(), "box", {1000, 50, -300}}});
  const auto triangles = [&](const char* file) {
    std::vector<int> counts;
    const json walk = json_of(run_recede({"walk", folder / file, "--frames", "4", "--json"}));
    for (const json& frame : walk["frames"]) counts.push_back(frame["triangles"]);
    return counts;
  };
  EXPECT_EQ(triangles("here.step"), triangles("there.step"));
}

TEST(Walk, GoesFromAndToWhereItIsTold) {
  const TempFolder folder;
  const std::string box = write_rounded_box(folder);
  const auto frames = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"walk", box, "--frames", "3", "--json"});
    std::vector<int> counts;
    const json walk = json_of(run_recede(more));
    for (const json& frame : walk["frames"]) counts.push_back(frame["triangles"]);
    return counts;
  };
  const std::vector<int> back = frames({"--from", "0", "0", "80", "--to", "0", "0", "4000"});
  EXPECT_GT(back.front(), back.back());
  EXPECT_EQ(frames({"--from", "0", "0", "80", "--to", "0", "0", "80", "--look-at", "0", "0", "900"}),
            (std::vector<int>{0, 0, 0}))
      << "looks away from it";
  const std::vector<int> steady = frames({"--from", "0", "0", "80", "--to", "0", "0", "80"});
  EXPECT_EQ(steady[1], steady[2]);
  EXPECT_LT(frames({"--from", "0", "0", "80", "--to", "0", "0", "80", "--most-new-triangles", "20"})[0],
            steady[0]);
}

TEST(CadBake, HasItsFieldsInTheDocumentation) {
  const TempFolder folder;
  const std::string box = write_rounded_box(folder);
  std::set<std::string> fields;
  collect_fields(json_of(run_recede({"bake", box, "-o", folder / "out", "--no-report", "--json"})), fields);
  collect_fields(json_of(run_recede({"seams", box, "--json"})), fields);
  collect_fields(json_of(run_recede({"walk", box, "--frames", "2", "--json"})), fields);
  expect_explained(fields);
}

}  // namespace
}  // namespace recede::test
