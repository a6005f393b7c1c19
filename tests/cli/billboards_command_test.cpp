#include "run_recede.h"
#include "temp_folder.h"
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/raster.h>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

namespace recede::test {
namespace {

using testing::HasSubstr;

TEST(BillboardsCommand, WritesACloudForEachError) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 500), out = folder / "cloud.ply";
  const nlohmann::json result =
      json_of(run_recede({"billboards", sphere, "-o", out, "--relative-errors", "0.02", "0.05", "--json"}));
  ASSERT_EQ(result["clouds"].size(), 2u);
  ASSERT_EQ(result["outputs"].size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const nlohmann::json& cloud = result["clouds"][i];
    EXPECT_LE(cloud["largest_error"].get<double>(), cloud["error"].get<double>());
    EXPECT_LE(cloud["largest_deviation"].get<double>(), 60.001);
    const PolygonSoup quads = read_soup(result["outputs"][i].get<std::string>());
    EXPECT_EQ(quads.n_faces(), cloud["billboards"].get<std::size_t>());
    EXPECT_EQ(quads.vertex_colors.size(), quads.positions.size());
  }
  EXPECT_GT(result["clouds"][0]["billboards"], result["clouds"][1]["billboards"]);
}

TEST(BillboardsCommand, CoversByPlanesInOneFile) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 300), out = folder / "cloud.obj";
  const nlohmann::json result = json_of(run_recede(
      {"billboards", sphere, "-o", out, "--method", "planes", "--relative-errors", "0.05", "--json"}));
  EXPECT_EQ(result["outputs"], nlohmann::json::array({out}));
  EXPECT_EQ(read_soup(out).n_faces(), result["clouds"][0]["billboards"].get<std::size_t>());
}

TEST(BillboardsCommand, SimplifiesWhereItIsAskedTo) {
  const nlohmann::json result =
      json_of(run_recede({"billboards", "tree", "--method", "simplification", "--normal-deviation", "40",
                          "--relative-errors", "0.05", "--json"}));
  EXPECT_LE(result["clouds"][0]["largest_deviation"].get<double>(), 40.001);
  EXPECT_LE(result["clouds"][0]["largest_error"], result["clouds"][0]["error"]);
}

TEST(BillboardsCommand, TakesAFileWithoutFacesAsPoints) {
  const TempFolder folder;
  std::string text;
  for (int x = 0; x < 12; ++x) {
    for (int y = 0; y < 12; ++y) text += fmt::format("v {} {} 0\n", x, y);
  }
  folder.write("scan.obj", text);
  const CommandResult run =
      run_recede({"billboards", folder / "scan.obj", "--relative-errors", "0.01", "--json"});
  EXPECT_THAT(run.remarks, HasSubstr("144 points"));
  EXPECT_THAT(run.remarks, HasSubstr("both sides"));
  const nlohmann::json result = json_of(run);
  EXPECT_EQ(result["points"], 144);
  EXPECT_EQ(result["clouds"][0]["billboards"], 1) << "they are in one plane";
  folder.write("one.obj", "v 1 2 3\n");
  EXPECT_THAT(complaint_of(run_recede({"billboards", folder / "one.obj"}), 1), HasSubstr("two places"));
}

TEST(BillboardsCommand, TakesTheBuiltInTree) {
  const nlohmann::json result =
      json_of(run_recede({"billboards", "tree", "--two-sided", "--relative-errors", "0.03", "--json"}));
  EXPECT_EQ(result["left_out"], 0);
  EXPECT_LT(result["clouds"][0]["billboards"].get<std::size_t>(), 2400u);  // it has as many leaves
}

TEST(BillboardsCommand, SaysInTextWhatTheDocumentHas) {
  const TempFolder folder;
  // A roof: two faces that lean by 45 degrees, and on its ridge one without an area.
  folder.write("roof.obj",
               "v 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 1\nv 1 2 0\nv 0 2 0\nv 0.5 1 1\n"
               "f 1 2 3 4\nf 4 3 5 6\nf 4 7 3\n");
  const std::vector<std::string> arguments{"billboards", folder / "roof.obj", "--errors", "2"};
  std::vector<std::string> with_json = arguments;
  with_json.emplace_back("--json");
  const CommandResult text = run_recede(arguments);
  EXPECT_THAT(text.remarks, HasSubstr("1 faces without area are left out\n"));
  const nlohmann::json result = json_of(run_recede(with_json));
  EXPECT_EQ(result["left_out"], 1);
  const nlohmann::json& cloud = result["clouds"][0];
  EXPECT_EQ(cloud["billboards"], 1);
  EXPECT_NEAR(cloud["largest_deviation"], 45, 1e-9);
  EXPECT_THAT(text.output, testing::ContainsRegex("\n2 +1 .* 45\\.0 deg\n"));
}

TEST(BillboardsCommand, WritesTexturesAsLevels) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 500), out = folder / "out";
  const nlohmann::json result =
      json_of(run_recede({"billboards", sphere, "--folder", out, "--relative-errors", "0.02", "0.05",
                          "--mipmaps", "3", "--json"}));
  EXPECT_EQ(result["outputs"], nlohmann::json::array({folder / "out/sphere.glb"}));
  for (std::size_t i = 0; i < 2; ++i) {
    const nlohmann::json& textures = result["clouds"][i]["textures"];
    for (const char* kind : {"color", "normal", "height"}) {
      const Raster picture = read_png(textures[kind].get<std::string>());
      EXPECT_EQ(picture.width, textures["size"][0]);
      EXPECT_EQ(picture.height, textures["size"][1]);
      for (int k = 1; k <= 3; ++k) {
        const Raster smaller =
            read_png(folder / fmt::format("out/sphere.recede/level_{}_{}_{}.png", i, kind, k));
        EXPECT_EQ(smaller.width, picture.width >> k);
      }
    }
    EXPECT_GT(textures["covered"], 0.3);
  }
  EXPECT_LT(result["clouds"][0]["textures"]["switch_distance"],
            result["clouds"][1]["textures"]["switch_distance"]);
}

TEST(BillboardsCommand, KeepsToABudget) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 500), out = folder / "out";
  const nlohmann::json result =
      json_of(run_recede({"billboards", sphere, "--folder", out, "--most-bytes", "64kb", "--json"}));
  ASSERT_EQ(result["clouds"].size(), 1u);
  EXPECT_LE(result["clouds"][0]["textures"]["bytes"], 65536);
  EXPECT_GT(result["clouds"][0]["textures"]["bytes"], 32768);
  EXPECT_THAT(complaint_of(run_recede({"billboards", sphere, "--most-bytes", "7"}), 2), HasSubstr("too few"));
}

TEST(BillboardsCommand, WritesReflectanceThatRenderDraws) {
  const TempFolder folder;
  // Two leaves, one over the other.
  folder.write(
      "leaves.obj",
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.2 0.2 0.4\nv 0.8 0.2 0.4\nv 0.8 0.8 0.4\nv 0.2 0.8 0.4\n"
      "f 1 2 3 4\nf 5 6 7 8\n");
  const std::string leaves = folder / "leaves.obj", out = folder / "out", drawn = out + "/leaves.recede";
  const nlohmann::json result = json_of(run_recede(
      {"billboards", leaves, "--folder", out, "--errors", "0.2", "--two-sided", "--reflectance", "--json"}));
  const nlohmann::json& written = result["clouds"][0]["reflectance"];
  EXPECT_EQ(written["file"], drawn + "/level_0.reflectance");
  EXPECT_LT(written["bytes"], written["raw_bytes"]);
  EXPECT_LT(written["rms"], 0.1);
  EXPECT_THAT(json_of(run_recede({"info", drawn, "--json"}))["levels"][0]["also_holds"],
              testing::ElementsAre("billboards", "reflectance"));
  const auto picture_of = [&](std::vector<std::string> options) {
    std::vector<std::string> command{
        "render",         drawn, "-o",         folder / "p.png", "--image-width", "30",
        "--image-height", "30",  "--lighting", "direct"};
    command.insert(command.end(), options.begin(), options.end());
    EXPECT_EQ(run_recede(command).code, 0);
    return read_png(folder / "p.png").samples;
  };
  EXPECT_NE(picture_of({}), picture_of({"--reflectance"}));
  std::filesystem::remove(drawn + "/level_0.reflectance");
  EXPECT_THAT(complaint_of(run_recede({"render", drawn, "-o", folder / "p.png", "--reflectance"}), 1),
              HasSubstr("level_0.reflectance: isn't there"));
  EXPECT_THAT(complaint_of(run_recede({"render", "sphere", "-o", folder / "p.png", "--reflectance"}), 2),
              HasSubstr("no billboards"));
}

TEST(BillboardsCommand, SaysFromWhichDistanceEvenTheFinestCloudServes) {
  const TempFolder folder;
  const nlohmann::json result =
      json_of(run_recede({"billboards", write_sphere(folder, 500), "--folder", folder / "out",
                          "--relative-errors", "0.02", "0.05", "--pixel-error", "2", "--json"}));
  double before = 0;
  for (const nlohmann::json& cloud : result["clouds"]) {
    const nlohmann::json& textures = cloud["textures"];
    // Two pixels of 1080 in 45 degrees.
    const double distance =
        textures["error"]["bound"].get<double>() * 1080 / (4 * std::tan(std::numbers::pi / 8));
    EXPECT_NEAR(textures["switch_distance"], distance, 1e-9 * distance);
    EXPECT_GT(textures["switch_distance"], before);
    before = textures["switch_distance"];
  }
}

TEST(BillboardsCommand, SaysWhatCantBe) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 100), out = folder / "cloud.ply";
  EXPECT_THAT(complaint_of(run_recede({"billboards", sphere, "--errors", "2", "1"}), 2),
              HasSubstr("increase"));
  EXPECT_THAT(complaint_of(run_recede({"billboards", sphere, "--method", "magic"}), 2), HasSubstr("magic"));
  EXPECT_THAT(complaint_of(run_recede({"billboards", sphere, "-o", "cloud.doc"}), 1), HasSubstr("cloud.doc"));
  EXPECT_THAT(complaint_of(run_recede({"billboards", sphere, "--mipmaps", "2"}), 2), HasSubstr("--folder"));
  EXPECT_THAT(complaint_of(run_recede({"billboards", sphere, "--reflectance"}), 2), HasSubstr("--folder"));
  EXPECT_THAT(complaint_of(run_recede({"billboards", sphere, "--folder", sphere}), 1), HasSubstr("folder"));
  EXPECT_THAT(
      complaint_of(run_recede({"billboards", sphere, "--folder", folder / "out", "--errors", "1e-7"}), 2),
      HasSubstr("too small"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
  EXPECT_THAT(complaint_of(run_recede({"billboards", folder / "flat.obj", "-o", out}), 1), HasSubstr("area"));
  EXPECT_FALSE(std::filesystem::exists(folder / "cloud.ply"));
}

}  // namespace
}  // namespace recede::test
