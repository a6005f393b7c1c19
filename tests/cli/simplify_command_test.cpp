// `recede simplify`, and what `recede info` and `recede compare` say of what it wrote.
#include "run_recede.h"
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/sample_models.h>

#include <fmt/format.h>

namespace recede::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

json simplify_sphere(const TempFolder& folder, const std::string& out, std::vector<std::string> more) {
  std::vector<std::string> arguments{"simplify", write_sphere(folder, 2000), "-o", folder / out, "--json"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return json_of(run_recede(arguments));
}

TEST(SimplifyCommand, ReportsEveryDocumentedField) {
  const TempFolder folder;
  const json result = simplify_sphere(folder, "small.ply", {"--ratio", "0.25"});
  EXPECT_EQ(result.at("command"), "simplify");
  EXPECT_EQ(result.at("input"), (folder / "sphere.ply").string());
  EXPECT_EQ(result.at("output"), (folder / "small.ply").string());
  const std::size_t before = result.at("faces_before"), after = result.at("faces");
  EXPECT_GE(before, 2000u);
  EXPECT_LE(after, before / 4);
  EXPECT_GT(after, before / 5);
  EXPECT_EQ(result.at("vertices_before"), before / 2 + 2) << "a closed surface of triangles";
  EXPECT_EQ(result.at("vertices"), after / 2 + 2);
  EXPECT_GT(result.at("collapses"), 0);
  EXPECT_GT(result.at("passes"), 0);
  EXPECT_EQ(result.at("stop_reason"), "face target reached");
  for (const char* reason : {"border", "topology", "duplicate", "flip", "degenerate", "deviation", "error"}) {
    EXPECT_TRUE(result.at("refused").at(reason).is_number_unsigned()) << reason;
  }
  EXPECT_GT(result.at("error_estimate"), 0);
  expect_error_fields(result.at("error"), result.at("diagonal"));
  EXPECT_EQ(result.at("bytes"), std::filesystem::file_size(folder / "small.ply"));
  EXPECT_THAT(result.at("written_without"), IsEmpty());
  EXPECT_GE(result.at("seconds"), 0);
  EXPECT_TRUE(result.at("repairs").is_array());
  for (const json& step : result.at("repairs")) {
    EXPECT_TRUE(step.at("step").is_string() && step.at("changed").is_number() &&
                step.at("detail").is_string());
  }
}

TEST(SimplifyCommand, AgreesWithCompareOnTheErrorItReports) {
  const TempFolder folder;
  const json result = simplify_sphere(folder, "small.ply", {"--ratio", "0.25"});
  const json compared = json_of(run_recede(
      {"compare", folder / "sphere.ply", folder / "small.ply", "--bound-tolerance", "0.05", "--json"}));
  for (const char* name : {"max", "rms", "bound"}) {
    EXPECT_NEAR(compared.at("error").at(name), result.at("error").at(name), 1e-12) << name;
  }
}

TEST(SimplifyCommand, LeavesTheErrorOutWhenToldNotToMeasure) {
  const TempFolder folder;
  const json result = simplify_sphere(folder, "small.ply", {"--ratio", "0.25", "--no-measure"});
  EXPECT_TRUE(result.at("error").is_null());
  EXPECT_GT(result.at("error_estimate"), 0);
}

class EveryFormat : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(SimplifyCommand, EveryFormat,
                         testing::Values("obj", "ply", "stl", "off", "glb", "gltf"),
                         [](const auto& tested) { return std::string(tested.param); });

TEST_P(EveryFormat, IsWrittenAndReadBack) {
  const TempFolder folder;
  const std::string name = std::string("small.") + GetParam();
  const json written = simplify_sphere(folder, name, {"--faces", "300"});
  const json read = json_of(run_recede({"info", folder / name, "--json"}));
  EXPECT_EQ(read.at("command"), "info");
  EXPECT_EQ(read.at("faces"), written.at("faces"));
  EXPECT_EQ(read.at("triangles"), written.at("faces"));
  EXPECT_EQ(read.at("vertices"), written.at("vertices"));
  EXPECT_EQ(read.at("components"), 1);
  EXPECT_EQ(read.at("border_edges"), 0);
  EXPECT_NEAR(read.at("diagonal"), written.at("diagonal"), 0.2);
  EXPECT_THAT(names_below(folder / ""), ElementsAre(name, "sphere.ply"));
}

TEST(SimplifyCommand, SaysWhatTheFormatCannotHold) {
  const TempFolder folder;
  write_soup(folder / "teapot.ply", make_teapot(4));
  const CommandResult run =
      run_recede({"simplify", folder / "teapot.ply", "-o", folder / "small.stl", "--ratio", "0.5", "--json"});
  EXPECT_THAT(json_of(run).at("written_without"), Not(IsEmpty()));
  EXPECT_THAT(run.remarks, HasSubstr("small.stl: written without "));
}

TEST(SimplifyCommand, KeepsQuadsAsQuads) {
  const TempFolder folder;
  json_of(run_recede({"simplify", write_sphere(folder, 2000, false), "-o", folder / "small.ply", "--ratio",
                      "0.25", "--json"}));
  const json read = json_of(run_recede({"info", folder / "small.ply", "--json"}));
  EXPECT_GT(read.at("quads").get<double>(), 0.5 * read.at("faces").get<double>());
}

TEST(SimplifyCommand, PrintsNothingButResultsWhenQuiet) {
  const TempFolder folder;
  write_soup(folder / "teapot.ply", make_teapot(4));  // has borders that meet: reading it causes remarks
  const std::vector<std::string> arguments{
      "simplify", folder / "teapot.ply", "-o", folder / "small.stl", "--faces", "1"};
  EXPECT_THAT(run_recede(arguments).remarks, AllOf(HasSubstr("recede: split_non_manifold: added 1 copies"),
                                                   HasSubstr("written without"), HasSubstr("not reached")));
  for (const char* quiet : {"--quiet", "-q"}) {
    std::vector<std::string> with_quiet = arguments;
    with_quiet.emplace_back(quiet);
    const CommandResult run = run_recede(with_quiet);
    EXPECT_EQ(run.code, 0);
    EXPECT_EQ(run.remarks, "");
    EXPECT_THAT(run.output, HasSubstr("faces"));
  }
}

TEST(SimplifyCommand, PrintsTheErrorsThatItsDocumentHolds) {
  const TempFolder folder;
  std::vector<std::string> arguments{
      "simplify", write_sphere(folder, 2000), "-o", folder / "small.ply", "--ratio", "0.25"};
  const std::string text = run_recede(arguments).output;
  arguments.emplace_back("--json");
  const json result = json_of(run_recede(arguments));
  const auto line = [&](const char* name) {
    return fmt::format("{:.4g} ({:.3g} %)", result.at("error").at(name).get<double>(),
                       100 * result.at("error").at(std::string(name) + "_relative").get<double>());
  };
  EXPECT_THAT(text,
              AllOf(HasSubstr(fmt::format("faces        {} -> {}\n", result.at("faces_before").get<int>(),
                                          result.at("faces").get<int>())),
                    HasSubstr("error max    " + line("max") + ", sampled\n"),
                    HasSubstr("error bound  " + line("bound") + ", certified\n"),
                    HasSubstr("error rms    " + line("rms") + "\n"),
                    HasSubstr("written      " + (folder / "small.ply").string() + "\n")));
}

TEST(SimplifyCommand, GivesTheBestMeshAndTheReasonWhenTheTargetIsOutOfReach) {
  const TempFolder folder;
  const CommandResult run = run_recede(
      {"simplify", write_sphere(folder, 500), "-o", folder / "small.ply", "--faces", "1", "--json"});
  const json result = json_of(run);
  EXPECT_EQ(result.at("stop_reason"), "no permitted collapse left");
  EXPECT_GE(result.at("faces"), 4) << "no closed surface has fewer";
  EXPECT_THAT(run.remarks, HasSubstr("recede: the target was not reached: no permitted collapse left"));
  EXPECT_EQ(json_of(run_recede({"info", folder / "small.ply", "--json"})).at("faces"), result.at("faces"));
}

TEST(SimplifyCommand, StopsAtAnErrorWithoutCallingItAMiss) {
  const TempFolder folder;
  const CommandResult run = run_recede({"simplify", write_sphere(folder, 2000), "-o", folder / "small.ply",
                                        "--relative-error", "0.001", "--json"});
  const json result = json_of(run);
  EXPECT_EQ(result.at("stop_reason"), "error target reached");
  EXPECT_LE(result.at("error_estimate").get<double>(), 0.001 * result.at("diagonal").get<double>());
  EXPECT_EQ(run.remarks, "");
}

TEST(SimplifyCommand, WritesTheSameBytesForAnyNumberOfThreads) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 20000);
  for (const char* cost : {"volume", "normal_deviation"}) {
    for (const std::string extension : {".ply", ".glb"}) {
      const auto bytes = [&](const std::string& threads) {
        std::filesystem::create_directory(folder / threads);  // a GLB holds its own name
        const std::string out = folder / (threads + "/small" + extension);
        EXPECT_EQ(run_recede({"simplify", sphere, "-o", out, "--ratio", "0.2", "--cost", cost, "--no-measure",
                              "--threads", threads})
                      .code,
                  0);
        return read_whole_file(out);
      };
      EXPECT_TRUE(bytes("1") == bytes("2")) << cost << extension;
    }
  }
}

}  // namespace
}  // namespace recede::test
