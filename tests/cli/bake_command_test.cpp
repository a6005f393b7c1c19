// `recede bake`: the levels, the files, and what the GLB says of them.
#include "pictures.h"
#include "run_recede.h"
#include <recede/geometry/exr.h>
#include <recede/geometry/mesh_io.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace recede::test {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Bakes a small sphere into `out` below the folder.
json bake_sphere(const TempFolder& folder, const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"bake", write_sphere(folder, 2000), "-o", folder / "out", "--json"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const CommandResult run = run_recede(arguments);
  EXPECT_EQ(run.remarks, "") << "no progress bar off a terminal, and nothing to remark";
  return json_of(run);
}

/// Distance at which `error` covers one pixel: d = error r / (2 tan(alpha / 2)).
double expected_switch_distance(double error, double image_height, double degrees, double pixels) {
  return pixels > 0 ? error * image_height / (2 * pixels * std::tan(degrees * std::numbers::pi / 360)) : 0;
}

void expect_levels_in_order(const json& levels) {
  for (std::size_t i = 1; i < levels.size(); ++i) {
    EXPECT_LT(levels[i].at("faces"), levels[i - 1].at("faces")) << i;
    EXPECT_GE(levels[i].at("switch_distance"), levels[i - 1].at("switch_distance")) << i;
    EXPECT_LE(levels[i].at("screen_coverage"), levels[i - 1].at("screen_coverage")) << i;
    EXPECT_GE(levels[i].at("error").at("bound"), levels[i].at("error").at("max")) << i;
    EXPECT_GE(levels[i].at("error").at("max"), levels[i].at("error").at("rms")) << i;
  }
}

TEST(BakeCommand, MakesTheLevelsOfTheRatiosAndEveryDocumentedField) {
  const TempFolder folder;
  const json result = bake_sphere(folder, {"--ratios", "0.5", "0.2", "0.05", "--no-report"});
  EXPECT_EQ(result.at("command"), "bake");
  EXPECT_EQ(result.at("hierarchy"), (folder / "out/sphere.glb").string());
  EXPECT_EQ(result.at("folder"), (folder / "out/sphere.recede").string());
  EXPECT_TRUE(result.at("report").is_null());
  EXPECT_GT(result.at("seconds"), 0);
  EXPECT_TRUE(result.at("repairs").is_array());
  const json& levels = result.at("levels");
  ASSERT_EQ(levels.size(), 4u);
  const double faces = levels[0].at("faces"), diagonal = result.at("diagonal");
  EXPECT_EQ(levels[0].at("error").at("bound"), 0);
  EXPECT_EQ(levels[0].at("switch_distance"), 0);
  EXPECT_EQ(levels[0].at("stop_reason"), "");
  const std::vector<double> ratios{1, 0.5, 0.2, 0.05};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(levels[i].at("level"), i);
    EXPECT_LE(levels[i].at("faces").get<double>(), ratios[i] * faces);
    EXPECT_EQ(levels[i].at("bytes"), std::filesystem::file_size(levels[i].at("file").get<std::string>()));
    EXPECT_DOUBLE_EQ(levels[i].at("error").at("bound_relative").get<double>(),
                     levels[i].at("error").at("bound").get<double>() / diagonal);
    EXPECT_GE(levels[i].at("seconds").at("simplify"), 0);
    EXPECT_GE(levels[i].at("seconds").at("measure"), 0);
  }
  expect_levels_in_order(levels);
}

TEST(BakeCommand, MakesLevelsWithTheFacesAskedForInEitherNotation) {
  const TempFolder folder;
  for (const std::vector<std::string>& faces : {std::vector<std::string>{"1000", "300"}, {"1000,300"}}) {
    std::vector<std::string> arguments{"--no-report", "--faces"};
    arguments.insert(arguments.end(), faces.begin(), faces.end());
    const json levels = bake_sphere(folder, arguments).at("levels");
    ASSERT_EQ(levels.size(), 3u);
    EXPECT_EQ(levels[1].at("faces"), 1000);
    EXPECT_EQ(levels[2].at("faces"), 300);
  }
  EXPECT_THAT(complaint_of(run_recede({"bake", "sphere", "-o", folder / "no", "--faces", "-5"}), 2),
              HasSubstr("--faces: -5 must be at least 0"));
}

TEST(BakeCommand, SaysInTextWhatServesFarAway) {
  const TempFolder folder;
  const std::string text =
      run_recede({"bake", write_sphere(folder, 500), "-o", folder / "out", "--no-report"}).output;
  EXPECT_THAT(text,
              testing::ContainsRegex("from distance   which are better there\n *[0-9.]+   triangles: "));
  EXPECT_THAT(text,
              HasSubstr("Errors and distances are object units; distances count from the bounding sphere, "
                        "for pictures 1080 pixels high, 45 degrees, pixel error 1.\n"));
}

TEST(BakeCommand, PrintsSharesMapsAndPlacesAndWhatReadingRepaired) {
  const TempFolder folder;
  write_soup(folder / "ball.obj", read_soup(write_sphere(folder, 500)));
  const std::string twice =
      folder.write("ball.obj", read_whole_file(folder / "ball.obj") + "v 9 9 9\nv 9 9 9\n");
  std::vector<std::string> arguments{"bake",
                                     twice,
                                     "-o",
                                     folder / "out",
                                     "--ratios",
                                     "0.3",
                                     "--no-billboards",
                                     "--maps",
                                     "normal,displacement",
                                     "--map-size",
                                     "64"};
  const CommandResult run = run_recede(arguments);
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.remarks, HasSubstr("recede: merge_identical_vertices: "));
  arguments.emplace_back("--json");
  const json result = json_of(run_recede(arguments));
  const json& level = result.at("levels")[1];
  const double bound = level.at("error").at("bound"), share = level.at("error").at("bound_relative");
  EXPECT_THAT(run.output,
              testing::AllOf(
                  HasSubstr(fmt::format("{:.3g} ({:.2g} %)", bound, 100 * share)),
                  HasSubstr("new: no texture coordinates\n"),
                  HasSubstr(fmt::format("{:.3g}", level.at("maps").at("displaced").at("rms").get<double>())),
                  HasSubstr("hierarchy  " + result.at("hierarchy").get<std::string>() + "\n"),
                  HasSubstr("report     " + result.at("report").get<std::string>() + "\n")));
}

TEST(BakeCommand, TurnsThePicturesOfTheReportAndLeavesTheViewerOut) {
  const TempFolder folder;
  const auto report = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"--ratios", "0.3", "--no-billboards"});
    bake_sphere(folder, more);
    return read_whole_file(folder / "out/report.html");
  };
  const auto first_picture = [](const std::string& html) {
    const std::size_t at = html.find("data:image/png;base64,");
    EXPECT_NE(at, html.npos);
    return html.substr(at, html.find('"', at) - at);
  };
  const std::string upright = report({});
  EXPECT_EQ(first_picture(report({"--up", "y", "--viewer-triangles", "0"})), first_picture(upright));
  EXPECT_THAT(read_whole_file(folder / "out/report.html"), testing::Not(HasSubstr("id=\"viewer-canvas\"")));
  EXPECT_NE(first_picture(report({"--up", "x"})), first_picture(upright));
}

TEST(BakeCommand, KeepsTheCertifiedBoundsThatErrorsAskFor) {
  const TempFolder folder;
  const json levels = bake_sphere(folder, {"--errors", "0.02", "0.08", "--no-report"}).at("levels");
  ASSERT_EQ(levels.size(), 3u);
  EXPECT_LE(levels[1].at("error").at("bound"), 0.02);
  EXPECT_LE(levels[2].at("error").at("bound"), 0.08);
  EXPECT_GT(levels[2].at("error").at("bound"), 0.02) << "uses what it is allowed";
  expect_levels_in_order(levels);
}

TEST(BakeCommand, TakesErrorsAsSharesOfTheDiagonal) {
  const TempFolder folder;
  const json levels = bake_sphere(folder, {"--relative-errors", "0.005", "0.02", "--no-report"}).at("levels");
  ASSERT_EQ(levels.size(), 3u);
  EXPECT_LE(levels[1].at("error").at("bound_relative"), 0.005);
  EXPECT_LE(levels[2].at("error").at("bound_relative"), 0.02);
  expect_levels_in_order(levels);
}

TEST(BakeCommand, MakesLevelsThatServeAtTheDistancesAskedFor) {
  const TempFolder folder;
  const json levels = bake_sphere(folder, {"--distances", "20", "80", "--image-height", "720",
                                           "--field-of-view", "60", "--pixel-error", "0.5", "--no-report"})
                          .at("levels");
  ASSERT_EQ(levels.size(), 3u);
  EXPECT_LE(levels[1].at("switch_distance"), 20);
  EXPECT_LE(levels[2].at("switch_distance"), 80);
  for (const json& level : levels) {
    EXPECT_NEAR(level.at("switch_distance"),
                expected_switch_distance(level.at("error").at("bound"), 720, 60, 0.5), 1e-9);
  }
  expect_levels_in_order(levels);
}

TEST(BakeCommand, WritesTheHierarchyAndTheReportAndNothingElse) {
  const TempFolder folder;
  const json result = bake_sphere(folder, {"--ratios", "0.3", "0.1"});
  EXPECT_THAT(
      names_below(folder / "out"),
      ElementsAre("report.html", "report.json", "sphere.glb", "sphere.recede", "sphere.recede/hierarchy.json",
                  "sphere.recede/level_0.ply", "sphere.recede/level_1.ply", "sphere.recede/level_2.ply"));
  EXPECT_EQ(result.at("report"), (folder / "out/report.html").string());
  const json hierarchy = json::parse(read_whole_file(folder / "out/sphere.recede/hierarchy.json"));
  EXPECT_EQ(hierarchy.at("format"), "recede hierarchy");
  const json report = json::parse(read_whole_file(folder / "out/report.json"));
  ASSERT_EQ(report.at("levels").size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const json& printed = result.at("levels")[i];
    EXPECT_EQ(report.at("levels")[i].at("faces"), printed.at("faces"));
    EXPECT_EQ(report.at("levels")[i].at("error"), printed.at("error"));
    EXPECT_EQ(hierarchy.at("levels")[i].at("switch_distance"), printed.at("switch_distance"));
    EXPECT_EQ(json_of(run_recede({"info", printed.at("file"), "--json"})).at("faces"), printed.at("faces"));
  }
  const std::string html = read_whole_file(folder / "out/report.html");
  EXPECT_THAT(html, HasSubstr("</html>"));
  for (const char* reference : {"src=\"http", "href=\"http", "url(http", "@import"}) {
    EXPECT_EQ(html.find(reference), html.npos) << "one file that needs no network";
  }
}

TEST(BakeCommand, ReplacesAnEarlierHierarchyAsAWhole) {
  const TempFolder folder;
  bake_sphere(folder, {"--ratios", "0.5", "0.3", "0.1", "--no-report"});
  bake_sphere(folder, {"--ratios", "0.5", "--no-report"});
  EXPECT_THAT(names_below(folder / "out"),
              ElementsAre("sphere.glb", "sphere.recede", "sphere.recede/hierarchy.json",
                          "sphere.recede/level_0.ply", "sphere.recede/level_1.ply"));
}

TEST(BakeCommand, NamesTheLevelsInTheFirstNodeOfTheGlb) {
  const TempFolder folder;
  const json levels = bake_sphere(folder, {"--ratios", "0.5", "0.2", "0.05", "--no-report"}).at("levels");
  const json glb = json_of_glb(folder / "out/sphere.glb");
  EXPECT_THAT(glb.at("extensionsUsed"), ElementsAre("MSFT_lod"));
  EXPECT_THAT(glb.at("scenes")[0].at("nodes"), ElementsAre(0)) << "the other levels hang on the first";
  EXPECT_THAT(glb.at("nodes")[0].at("extensions").at("MSFT_lod").at("ids"), ElementsAre(1, 2, 3));
  const std::vector<double> coverage = glb.at("nodes")[0].at("extras").at("MSFT_screencoverage");
  ASSERT_EQ(coverage.size(), levels.size());
  EXPECT_TRUE(std::is_sorted(coverage.rbegin(), coverage.rend(), std::less_equal<>()))
      << "each below the one before";
  EXPECT_EQ(coverage.back(), 0) << "the coarsest level is never hidden";
  for (std::size_t i = 1; i < levels.size(); ++i) {
    EXPECT_DOUBLE_EQ(coverage[i - 1], levels[i].at("screen_coverage").get<double>())
        << "level i serves below";
  }
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const json& primitive =
        glb.at("meshes")[glb.at("nodes")[i].at("mesh").get<std::size_t>()].at("primitives")[0];
    EXPECT_EQ(glb.at("accessors")[primitive.at("indices").get<std::size_t>()].at("count").get<std::size_t>(),
              3 * levels[i].at("faces").get<std::size_t>());
  }
}

TEST(BakeCommand, WritesAGlbThatPassesTheKhronosValidator) {
  if (!has_gltf_validator()) GTEST_SKIP() << "the glTF validator isn't installed; ./dev test fetches it";
  const TempFolder folder;
  bake_sphere(folder, {"--ratios", "0.5", "0.1", "--no-report"});
  EXPECT_TRUE(is_valid_gltf(folder / "out/sphere.glb"));
}

TEST(BakeCommand, WritesTheMapsThatAreAskedFor) {
  const TempFolder folder;
  const json levels = bake_sphere(folder, {"--ratios", "0.5", "0.1", "--no-report", "--maps",
                                           "normal,displacement", "--map-size", "128"})
                          .at("levels");
  EXPECT_TRUE(levels[0].at("maps").is_null());
  for (std::size_t i = 1; i < 3; ++i) {
    const json& maps = levels[i].at("maps");
    EXPECT_EQ(maps.at("size"), 128);
    EXPECT_EQ(maps.at("atlas_reason"), "no texture coordinates");
    EXPECT_TRUE(maps.at("color").is_null());
    EXPECT_LT(maps.at("displaced").at("rms"), levels[i].at("error").at("rms"));
    EXPECT_LT(maps.at("missed"), maps.at("texels"));
    EXPECT_EQ(read_whole_file(maps.at("displacement").get<std::string>()).substr(1, 3), "PNG");
  }
  EXPECT_THAT(
      names_below(folder / "out/sphere.recede"),
      ElementsAre("hierarchy.json", "level_0.ply", "level_1.ply", "level_1_displacement.png",
                  "level_1_normal.png", "level_2.ply", "level_2_displacement.png", "level_2_normal.png"));
  if (!has_gltf_validator()) GTEST_SKIP() << "the glTF validator isn't installed; ./dev test fetches it";
  EXPECT_TRUE(is_valid_gltf(folder / "out/sphere.glb"));
}

TEST(BakeCommand, EndsATreeWithBillboardsAndSaysWhy) {
  const TempFolder folder;
  const std::string out = folder / "out";
  const json result =
      json_of(run_recede({"bake", "tree", "-o", out, "--ratios", "0.5", "--no-report", "--json"}));
  const json& last = result.at("levels").back();
  ASSERT_FALSE(last.at("billboards").is_null());
  EXPECT_TRUE(std::filesystem::exists(last.at("billboards").at("height").get<std::string>()));
  EXPECT_THAT(last.at("stop_reason").get<std::string>(), HasSubstr("billboards: pictures of"));
  const json& trials = result.at("far_levels");
  ASSERT_FALSE(trials.empty());
  EXPECT_TRUE(trials.back().at("takes_billboards").get<bool>());
  EXPECT_LT(trials.back().at("billboard_difference"), trials.back().at("triangle_difference"));
  // They can be drawn.
  const std::string picture = folder / "tree.png";
  const std::size_t number = result.at("levels").size() - 1;
  const CommandResult drawn =
      run_recede({"render", folder / "out/tree.recede", "-o", picture, "--level", std::to_string(number),
                  "--image-width", "40", "--image-height", "40"});
  EXPECT_EQ(drawn.code, 0) << drawn.remarks;
  const json plain = json_of(
      run_recede({"bake", "tree", "-o", out, "--ratios", "0.5", "--no-report", "--no-billboards", "--json"}));
  EXPECT_EQ(plain.at("levels").size(), 2u);
  EXPECT_TRUE(plain.at("far_levels").empty());
}

TEST(BakeCommand, WritesBillboardsThatPassTheKhronosValidator) {
  if (!has_gltf_validator()) GTEST_SKIP() << "the glTF validator isn't installed; ./dev test fetches it";
  const TempFolder folder;
  json_of(run_recede({"billboards", "tree", "--folder", folder / "out", "--two-sided", "--relative-errors",
                      "0.03", "--json"}));
  EXPECT_TRUE(is_valid_gltf(folder / "out/tree.glb"));
}

TEST(BakeCommand, WritesFloatMapsBesideTheOthersOnRequest) {
  const TempFolder folder;
  const json levels =
      bake_sphere(folder, {"--ratios", "0.2", "--no-report", "--maps", "normal,displacement", "--map-size",
                           "64", "--map-format", "exr", "--map-seam-weight", "1e4"})
          .at("levels");
  const json& maps = levels[1].at("maps");
  EXPECT_EQ(read_exr(maps.at("displacement_exr").get<std::string>()).width, 64);
  EXPECT_EQ(read_exr(maps.at("normal_exr").get<std::string>()).channels.size(), 3u);
  EXPECT_THAT(names_below(folder / "out/sphere.recede"),
              ElementsAre("hierarchy.json", "level_0.ply", "level_1.ply", "level_1_displacement.exr",
                          "level_1_displacement.png", "level_1_normal.exr", "level_1_normal.png"));
  if (!has_gltf_validator()) GTEST_SKIP() << "the glTF validator isn't installed; ./dev test fetches it";
  EXPECT_TRUE(is_valid_gltf(folder / "out/sphere.glb"));
}

TEST(BakeCommand, SaysThatThereAreNoColoursToBakeAndRefusesUnknownMaps) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 500), out = folder / "out";
  const CommandResult run = run_recede({"bake", sphere, "-o", out, "--ratios", "0.5", "--no-report", "--maps",
                                        "normal,color", "--map-size", "64"});
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.remarks, HasSubstr("has no colours to bake"));
  const auto complaint = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"bake", sphere, "-o", out, "--maps", "normal"});
    return complaint_of(run_recede(options), 2);
  };
  EXPECT_EQ(complaint({"--maps", "height"}),
            "recede: --maps: height isn't one of normal, displacement, color");
  EXPECT_EQ(complaint({"--map-size", "1"}), "recede: --map-size: 1 must be 4 to 16384");
  EXPECT_EQ(complaint({"--map-format", "tiff"}), "recede: --map-format: tiff isn't one of png, exr");
  EXPECT_EQ(complaint({"--map-seam-weight", "-1"}), "recede: --map-seam-weight: -1 must be at least 0");
}

TEST(BakeCommand, WritesTheSameLevelsForAnyNumberOfThreads) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 20000);
  for (const std::string threads : {"1", "2"}) {
    const std::string out = folder / threads;
    ASSERT_EQ(run_recede(
                  {"bake", sphere, "-o", out, "--ratios", "0.3", "0.05", "--no-report", "--threads", threads})
                  .code,
              0);
  }
  for (const std::string file : {"sphere.glb", "sphere.recede/level_0.ply", "sphere.recede/level_1.ply",
                                 "sphere.recede/level_2.ply"}) {
    EXPECT_TRUE(read_whole_file(folder / ("1/" + file)) == read_whole_file(folder / ("2/" + file))) << file;
  }
}

TEST(BakeCommand, SaysWhyALevelStoppedShortOfItsRatio) {
  const TempFolder folder;
  const json levels = bake_sphere(folder, {"--ratios", "0.5", "0.0001", "--no-report"}).at("levels");
  EXPECT_EQ(levels[1].at("stop_reason"), "face target reached");
  EXPECT_EQ(levels[2].at("stop_reason"), "no permitted collapse left");
}

TEST(BakeCommand, BakesInChunksWhatIsLargerThanMemory) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 400'000);
  const CommandResult run =
      run_recede({"bake", sphere, "-o", folder / "out", "--json", "--memory", "256M", "--ratios", "0.9",
                  "0.02", "0.005", "--no-billboards", "--viewer-triangles", "10000"});
  EXPECT_THAT(run.remarks, HasSubstr("faces, more than --memory allows; level 0 has"));
  EXPECT_THAT(run.remarks, HasSubstr("left out, as they would be finer than level 0: 36"));
  const json result = json_of(run);
  const json& levels = result.at("levels");
  ASSERT_EQ(levels.size(), 3u);
  EXPECT_GE(result.at("out_of_core").at("faces"), 400'000);
  EXPECT_GT(result.at("out_of_core").at("chunks"), 1);
  EXPECT_EQ(result.at("out_of_core").at("left_out").size(), 1u);
  EXPECT_LT(levels[0].at("faces"), 340'000);
  EXPECT_GT(levels[0].at("error").at("bound"), 0);
  EXPECT_EQ(levels[0].at("stop_reason"), "as many faces as memory allows");
  EXPECT_EQ(levels[0].at("switch_distance"), 0);
  expect_levels_in_order(levels);
  EXPECT_THAT(read_whole_file(folder / "out/report.html"), HasSubstr("more than memory allowed"));
  EXPECT_THAT(names_below(folder / "out"), testing::Not(testing::Contains(HasSubstr("scratch"))));
  // Where it fits, nothing is different.
  const std::string small = write_sphere(folder, 1000);
  const json fits = json_of(run_recede(
      {"bake", small, "-o", folder / "fits", "--json", "--memory", "1G", "--no-report", "--no-billboards"}));
  EXPECT_TRUE(fits.at("out_of_core").is_null());
  EXPECT_EQ(fits.at("levels")[0].at("error").at("bound"), 0);
}

TEST(BakeCommand, RefusesWhatIsNoNumber) {
  const TempFolder folder;
  EXPECT_EQ(complaint_of(run_recede({"bake", "sphere", "-o", folder / "out", "--ratios", "50%"}), 2),
            "recede: --ratios: 50% isn't a number");
}

TEST(BakeCommand, SaysWhatMemoryCantDo) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 300'000);
  const auto complaint = [&](std::vector<std::string> more, int code) {
    more.insert(more.begin(), {"bake", sphere, "-o", folder / "out"});
    const std::string text = complaint_of(run_recede(more), code);
    EXPECT_FALSE(std::filesystem::exists(folder / "out"));
    return text;
  };
  EXPECT_THAT(complaint({"--memory", "10M"}, 2), HasSubstr("memory must be at least 256 MiB"));
  EXPECT_THAT(complaint({"--memory", "500"}, 2), HasSubstr("at least 256 MiB, not 500 bytes"));
  for (const std::string size : {"much", "0.5G", "-5G", "500X"}) {
    EXPECT_THAT(complaint({"--memory=" + size}, 2),
                HasSubstr("--memory: " + size + " isn't a size such as 500M or 8G"));
  }
  EXPECT_THAT(complaint({"--memory", "256M", "--ratios", "0.9"}, 2), HasSubstr("no level is to have fewer"));
  EXPECT_THAT(complaint({"--memory", "256M", "--feature-angle", "30"}, 2), HasSubstr("--feature-angle"));
  // Text can't be read in pieces.
  const std::string text = folder / "text.obj";
  write_soup(text, read_soup(sphere));
  EXPECT_THAT(complaint_of(run_recede({"bake", text, "-o", folder / "out", "--memory", "256M"}), 1),
              HasSubstr("text.obj: may have more than"));
  std::filesystem::resize_file(sphere, std::filesystem::file_size(sphere) - 10);
  EXPECT_THAT(complaint({"--memory", "256M"}, 1), HasSubstr("sphere.ply: byte"));
}

TEST(BakeCommand, PutsTexturesIntoTheGlbAndBakesTheirColours) {
  const TempFolder folder;
  ASSERT_EQ(run_recede({"atlas", write_sphere(folder, 500), "-o", folder / "ball.obj"}).code, 0);
  std::string obj = read_whole_file(folder / "ball.obj");
  obj.insert(0, "mtllib skin.mtl\nusemtl skin\n");
  folder.write("skin.mtl", "newmtl skin\nKd 1 1 1\nmap_Kd skin.png\n");
  folder.write("ball.obj", obj);
  const std::vector<std::string> bake{"bake",         folder / "ball.obj", "-o",
                                      folder / "out", "--ratios",          "0.5",
                                      "--json",       "--no-report",       "--no-billboards"};
  const CommandResult without = run_recede(bake);
  EXPECT_THAT(without.remarks,
              testing::AllOf(HasSubstr("load_pictures: texture "), HasSubstr("skin.png: No such file")));
  EXPECT_EQ(json_of(without).at("repairs").front().at("changed"), 1);
  folder.write("skin.png", encode_png(raster_of(1, 1, {{200, 100, 50}})));
  EXPECT_EQ(run_recede(bake).remarks, "");
  const std::vector<Material> materials = read_soup(folder / "out/ball.glb").materials;
  ASSERT_EQ(materials.size(), 1u);
  EXPECT_EQ(*materials[0].base_color_picture, read_whole_file(folder / "skin.png"));
  std::vector<std::string> with_map = bake;
  with_map.insert(with_map.end(), {"--maps", "color", "--map-size", "64"});
  const json baked = json_of(run_recede(with_map));
  const Raster color = read_png(baked.at("levels")[1].at("maps").at("color").get<std::string>());
  for (std::size_t i = 0; i < color.samples.size(); ++i)
    ASSERT_NEAR(color.samples[i], (std::array{200, 100, 50}[i % 3]), 1) << "rounded twice";
}

TEST(BakeCommand, SaysWhenANewAtlasLeavesNoTexture) {
  const TempFolder folder;
  folder.write("skin.mtl", "newmtl skin\nmap_Kd skin.png\n");
  folder.write("skin.png", encode_png(raster_of(1, 1, {{200, 100, 50}})));
  ASSERT_EQ(
      run_recede({"simplify", write_sphere(folder, 500), "-o", folder / "ball.obj", "--ratio", "0.9"}).code,
      0);
  std::string obj = read_whole_file(folder / "ball.obj");
  obj.insert(0, "mtllib skin.mtl\nusemtl skin\n");
  folder.write("ball.obj", obj);
  const CommandResult run =
      run_recede({"bake", folder / "ball.obj", "-o", folder / "out", "--ratios", "0.5", "--json",
                  "--no-report", "--no-billboards", "--maps", "normal", "--map-size", "64"});
  EXPECT_THAT(
      run.remarks,
      HasSubstr("level 1 has a new atlas (no texture coordinates) and no texture; --maps color bakes"));
}

TEST(BakeCommand, WritesAGlbForEachLevelWhenAsked) {
  const TempFolder folder;
  const json plain = bake_sphere(folder, {"--ratios", "0.3", "--no-report"});
  EXPECT_TRUE(plain.at("levels")[1].at("glb").is_null());
  const json result = bake_sphere(
      folder, {"--ratios", "0.3", "--no-report", "--maps", "normal", "--map-size", "64", "--glb-per-level"});
  for (std::size_t i = 0; i < 2; ++i) {
    const json& level = result.at("levels")[i];
    EXPECT_EQ(level.at("glb"), (folder / fmt::format("out/sphere_level_{}.glb", i)).string());
    const MeshFromSoup read = read_mesh(level.at("glb").get<std::string>());
    EXPECT_EQ(read.mesh.n_faces(), level.at("faces"));
    EXPECT_NE(read.report.steps.front().name, "read_soup") << "nothing else is in it";
    EXPECT_EQ(i == 1, !read.mesh.materials.empty() && read.mesh.materials[0].normal_picture != nullptr);
  }
  EXPECT_THAT(read_mesh(result.at("hierarchy").get<std::string>()).report.steps.front().detail,
              HasSubstr("leaves 1 coarser level of detail aside"));
}

}  // namespace
}  // namespace recede::test
