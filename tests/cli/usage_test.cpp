// Help, and what `recede` says to arguments that it doesn't understand.
#include "run_recede.h"
#include <recede/version.h>

#include <fmt/format.h>

#include <sstream>

namespace recede::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class EveryCommand : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Usage, EveryCommand, testing::ValuesIn(k_commands),
                         [](const auto& tested) { return std::string(tested.param); });

TEST_P(EveryCommand, HelpsWithAnExampleAndTheCommonOptions) {
  const std::string command = GetParam();
  const CommandResult run = run_recede({command, "--help"});
  EXPECT_EQ(run.code, 0);
  EXPECT_EQ(run.remarks, "");
  EXPECT_THAT(run.output, AllOf(HasSubstr("Example"), HasSubstr("recede " + command + " "),
                                HasSubstr("--json"), HasSubstr("--threads"), HasSubstr("--quiet")));
}

TEST_P(EveryCommand, HelpsInWordsInsteadOfTypes) {
  const std::string help = run_recede({GetParam(), "--help"}).output;
  for (const char* type :
       {"FLOAT", "UINT", "INT", "TEXT", "REQUIRED", "Excludes", "Option Group", "[Exactly", "{"})
    EXPECT_THAT(help, Not(HasSubstr(type)));
  EXPECT_THAT(help, HasSubstr("--threads N (0 to 1024)"));
  EXPECT_EQ(run_recede({"help", GetParam()}).output, help);
}

TEST_P(EveryCommand, RefusesAnUnknownOptionByName) {
  // With as many arguments as any command needs, in files that would be written if it were known.
  const std::string command = GetParam();
  std::vector<std::string> arguments{command, "a", "-o", "b"};
  if (command == "compare" || command == "diff") arguments.insert(arguments.begin() + 2, "c");
  if (command == "compare" || command == "info") arguments.resize(arguments.size() - 2);
  arguments.emplace_back("--frobnicate");
  EXPECT_EQ(complaint_of(run_recede(arguments), 2), "recede: " + command + " has no option --frobnicate");
}

TEST_P(EveryCommand, AsksForItsArguments) {
  EXPECT_THAT(complaint_of(run_recede({GetParam()}), 2),
              testing::StartsWith("recede: " + std::string(GetParam()) + " needs "));
}

TEST(Usage, OfTheWholeCommandNamesTheCommands) {
  const CommandResult run = run_recede({"--help"});
  EXPECT_EQ(run.code, 0);
  std::istringstream lines(run.output.substr(run.output.find("\nCommands:\n") + 1));
  std::vector<std::string> names;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("  ")) names.push_back(line.substr(2, line.find(' ', 2) - 2));
  }
  EXPECT_THAT(names, testing::ElementsAreArray(k_commands));
}

TEST(Usage, HelpsWithKindsOfValuesAndTheirRanges) {
  EXPECT_EQ(run_recede({"help"}).output, run_recede({"--help"}).output);
  const std::string help = run_recede({"simplify", "--help"}).output;
  EXPECT_THAT(help, AllOf(HasSubstr("-o,--output FILE (required)"), HasSubstr("--ratio NUMBER  "),
                          HasSubstr("--uv-weight NUMBER (at least 0)"), HasSubstr("--cost NAME  ")));
  const std::string bake = run_recede({"bake", "--help"}).output;
  EXPECT_THAT(bake, AllOf(HasSubstr("--faces N ..."), HasSubstr("-o,--output FOLDER (required)")));
  EXPECT_THAT(run_recede({"extract", "--help"}).output, HasSubstr("--pixel-error NUMBER (with --eye)"));
}

TEST(Usage, TakesHyphensForUnderscoresInNames) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 200);
  const auto simplified = [&](const char* cost, const char* placement) {
    EXPECT_EQ(run_recede({"simplify", sphere, "-o", folder / "a.ply", "--ratio", "0.5", "--cost", cost,
                          "--placement", placement, "--no-measure"})
                  .code,
              0);
    return read_whole_file(folder / "a.ply");
  };
  EXPECT_EQ(simplified("normal-deviation", "half-edge"), simplified("normal_deviation", "half_edge"));
  EXPECT_EQ(json_of(run_recede({"subdivide", sphere, "-o", folder / "b.ply", "--subdivision-level", "0",
                                "--scheme", "catmull_clark", "--json"}))["scheme"],
            "catmull-clark");
}

TEST(Usage, NamesTheKindsOfFilesThatItWrites) {
  EXPECT_EQ(complaint_of(run_recede({"walk", "part.step", "-o", "z.txt"}), 2),
            "recede: --output: z.txt should end in .csv");
  EXPECT_EQ(complaint_of(run_recede({"seams", "part.step", "-o", "z.ply"}), 2),
            "recede: --output: z.ply should end in .obj");
  EXPECT_EQ(complaint_of(run_recede({"extract", "a.pmesh", "-o", "z.obj", "--morph-ratio", "0.1"}), 2),
            "recede: --output: z.obj should end in .glb, .gltf, .ply");
  EXPECT_THAT(complaint_of(run_recede({"extract", "a.pmesh", "-o", "z.txt"}), 1),
              HasSubstr(".obj .ply .stl"));
  EXPECT_THAT(complaint_of(run_recede({"render", "teapot", "-o", "z.txt"}), 1), HasSubstr(".png .exr"));
}

TEST(Usage, PrintsTheVersion) {
  const CommandResult run = run_recede({"--version"});
  EXPECT_EQ(run.code, 0);
  EXPECT_EQ(run.output, std::string(RECEDE_PROJECT_VERSION) + "\n");
}

TEST(Usage, TheHeaderHasTheVersionWholeAndInParts) {
  EXPECT_STREQ(RECEDE_VERSION, RECEDE_PROJECT_VERSION);
  EXPECT_EQ(fmt::format("{}.{}.{}", RECEDE_VERSION_MAJOR, RECEDE_VERSION_MINOR, RECEDE_VERSION_PATCH),
            RECEDE_PROJECT_VERSION);
}

TEST(Usage, NeedsACommand) { EXPECT_THAT(complaint_of(run_recede({}), 2), HasSubstr("recede --help")); }

TEST(Usage, NeedsTheExtensionOfAProgressiveMesh) {
  EXPECT_EQ(complaint_of(run_recede({"progressive", "teapot", "-o", "a.ply"}), 2),
            "recede: --output: a.ply should end in .pmesh");
}

TEST(Usage, NamesTheOptionThatWasMeant) {
  EXPECT_EQ(complaint_of(run_recede({"simplify", "teapot", "-o", "a.ply", "--rato", "0.1"}), 2),
            "recede: simplify has no option --rato (did you mean --ratio?)");
  EXPECT_EQ(complaint_of(run_recede({"simplify", "teapot", "-o", "a.ply", "--frobnicate", "1", "2"}), 2),
            "recede: simplify has no option --frobnicate");
  EXPECT_EQ(complaint_of(run_recede({"simplify", "teapot", "cow.off", "-o", "a.ply"}), 2),
            "recede: simplify: one argument too many: cow.off");
}

TEST(Usage, NamesAnUnknownCommand) {
  EXPECT_THAT(complaint_of(run_recede({"decimate", "teapot"}), 2), HasSubstr("decimate"));
}

/// Arguments that can't be meant, and a part of the answer.
struct BadValue {
  const char* name;
  std::vector<std::string> arguments;
  const char* answer;
  friend std::ostream& operator<<(std::ostream& out, const BadValue& value) { return out << value.answer; }
};

class BadValues : public testing::TestWithParam<BadValue> {};
INSTANTIATE_TEST_SUITE_P(
    Usage, BadValues,
    testing::Values(
        BadValue{"NegativeFaces", {"simplify", "teapot", "--faces", "-5"}, "--faces: -5 must be at least 0"},
        BadValue{"NegativeCharts", {"atlas", "teapot", "--charts", "-1"}, "--charts: -1 must be at least 0"},
        BadValue{"NoThickness", {"shell", "teapot", "--thickness", "0"}, "--thickness: 0 must be above 0"},
        BadValue{"InfiniteThickness",
                 {"shell", "teapot", "--thickness", "inf"},
                 "--thickness: inf isn't a finite number"},
        BadValue{"TooManySamples",
                 {"render", "teapot", "--samples", "70000"},
                 "--samples: 70000 must be 1 to 65536"},
        BadValue{"WrapThatIsNoNumber", {"shell", "--wrap", "teapot"}, "--wrap: teapot isn't a number"},
        BadValue{
            "RatioThatIsNoNumber", {"simplify", "teapot", "--ratio", "half"}, "--ratio: half isn't a number"},
        BadValue{"RatioWithoutNumber",
                 {"simplify", "teapot", "--ratio"},
                 "--ratio needs a value: at most this share"},
        BadValue{"EyeWithTwoNumbers", {"render", "teapot", "--eye", "1", "2"}, "--eye needs 3 values: where"},
        BadValue{"RatioTwice",
                 {"simplify", "teapot", "--ratio", "0.5", "--ratio", "0.6"},
                 "--ratio is given more than once"},
        BadValue{"RatioAboveOne", {"simplify", "teapot", "--ratio", "2"}, "the ratio must lie in (0, 1]"},
        BadValue{"NoFaces", {"simplify", "teapot", "--faces", "0"}, "the face target must be positive"},
        BadValue{"NegativeError",
                 {"simplify", "teapot", "--error", "-1"},
                 "the error target must not be negative"},
        BadValue{"UnknownCost", {"simplify", "teapot", "--cost", "beauty"}, "volume, normal_deviation"},
        BadValue{"CostByNumber", {"simplify", "teapot", "--cost", "1"}, "volume, normal_deviation"},
        BadValue{"UnknownPlacement", {"simplify", "teapot", "--placement", "near"}, "half_edge"},
        BadValue{"OptimalPlacementWithoutQuadrics",
                 {"simplify", "teapot", "--cost", "normal_deviation", "--placement", "optimal"},
                 "placement optimal needs the cost volume"},
        BadValue{"FeatureAngleAbove180",
                 {"simplify", "teapot", "--feature-angle", "200"},
                 "--feature-angle: 200 must be 0 to 180"},
        BadValue{
            "NegativeThreads", {"simplify", "teapot", "--threads", "-1"}, "--threads: -1 must be 0 to 1024"},
        BadValue{"ThreadsThatAreNoNumber",
                 {"simplify", "teapot", "--threads", "many"},
                 "--threads: many isn't a number"},
        BadValue{"RisingRatios", {"bake", "teapot", "--ratios", "0.1", "0.5"}, "ratios must decrease"},
        BadValue{"FallingErrors", {"bake", "teapot", "--errors", "0.5", "0.1"}, "errors must increase"},
        BadValue{"NegativeRelativeError",
                 {"bake", "teapot", "--relative-errors", "-1"},
                 "relative errors must be positive"},
        BadValue{"TwoWaysToChooseLevels",
                 {"bake", "teapot", "--ratios", "0.5", "--errors", "1"},
                 "only one of --faces, --ratios, --errors, --relative-errors, --distances may be given"},
        BadValue{"NoPixels", {"bake", "teapot", "--image-height", "0"}, "image height"},
        BadValue{"FieldOfViewOfAHalfTurn", {"bake", "teapot", "--field-of-view", "180"}, "field of view"},
        BadValue{"NoPixelError", {"bake", "teapot", "--pixel-error", "0"}, "pixel error"},
        BadValue{"UnknownKindOfMap", {"diff", "a.png", "b.png", "--map", "beauty"}, "flip, ssim, difference"},
        BadValue{"NoPixelsPerDegree",
                 {"diff", "a.png", "b.png", "--pixels-per-degree", "0"},
                 "--pixels-per-degree: 0 must be 1 to 1000"},
        BadValue{"LimitAboveOne",
                 {"diff", "a.png", "b.png", "--fail-above", "2"},
                 "--fail-above: 2 must be 0 to 1"},
        BadValue{"UnknownFootprint", {"dice", "teapot", "--footprint", "round"}, "by_side, mean, none"},
        BadValue{"PictureWithoutPixels",
                 {"dice", "teapot", "--image-width", "0"},
                 "--image-width: 0 must be 1 to 32768"},
        BadValue{"MeshWithoutHeights", {"dice", "teapot"}, "--displacement-map"},
        BadValue{
            "LevelAboveTen", {"subdivide", "teapot", "--subdivision-level", "11"}, "--subdivision-level"},
        BadValue{
            "SharpnessWithoutAngle", {"subdivide", "teapot", "--crease-sharpness", "1"}, "--crease-angle"},
        BadValue{"UnknownAxis", {"bake", "teapot", "--up", "w"}, "--up: w isn't one of x, y, z"}),
    [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(BadValues, AreWrongUsageAndWriteNothing) {
  const TempFolder folder;
  std::vector<std::string> arguments = GetParam().arguments;
  arguments.insert(arguments.end(), {"-o", (folder / "out.ply").string()});
  const std::string complaint = complaint_of(run_recede(arguments), 2);
  EXPECT_THAT(complaint, HasSubstr(GetParam().answer));
  EXPECT_LT(complaint.size(), 160u) << "a line that fits a terminal";
  EXPECT_THAT(names_below(folder / ""), testing::IsEmpty());
}

}  // namespace
}  // namespace recede::test
