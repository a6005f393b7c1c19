// `recede render` and `recede turntable` on meshes and on what `recede bake` wrote.
#include "run_recede.h"
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/raster.h>
#include <recede/render/image_difference.h>
#include <recede/render/image_io.h>
#include <recede/render/renderer.h>

#include <limits>
#include <numbers>

namespace recede::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::string bake_sphere(const TempFolder& folder) {
  const auto run = run_recede(
      {"bake", write_sphere(folder, 2000), "-o", folder / "out", "--no-report", "--ratios", "0.3", "0.05"});
  EXPECT_EQ(run.code, 0) << run.remarks;
  return folder / "out" / "sphere.recede";
}

/// Width and height by the header of the PNG file.
std::pair<unsigned, unsigned> size_of(const std::filesystem::path& path) {
  const std::string bytes = read_whole_file(path);
  const auto number = [&](std::size_t at) {
    unsigned value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes.at(at + i));
    return value;
  };
  EXPECT_EQ(bytes.substr(1, 3), "PNG");
  return {number(16), number(20)};
}

TEST(RenderCommand, SaysThatAFolderHidesABuiltInModel) {
  const TempFolder folder;
  const std::string input = folder / "sphere.ply";
  write_sphere(folder, 500);
  json_of(run_recede({"bake", input, "-o", folder / "teapot", "--no-report", "--no-billboards", "--json"}));
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  const CommandResult run = run_recede({"render", "teapot", "-o", "picture.png", "--samples", "1"});
  std::filesystem::current_path(before);
  EXPECT_EQ(run.code, 0);
  EXPECT_EQ(run.remarks,
            "recede: takes the folder teapot that is there, and not the built-in model of this name\n");
}

TEST(RenderCommand, FindsTheHierarchyInTheFolderThatBakeWrote) {
  const TempFolder folder;
  const std::string hierarchy = bake_sphere(folder), around = folder / "out";
  const auto draw = [&](const std::string& input) {
    const json result = json_of(run_recede({"render", input, "-o", folder / "a.png", "--image-width", "20",
                                            "--image-height", "20", "--eye", "0,0,1000", "--json"}));
    EXPECT_EQ(result.at("input"), input);
    EXPECT_EQ(result.at("level"), 2);
    return read_whole_file(folder / "a.png");
  };
  const std::string picture = draw(hierarchy);
  EXPECT_EQ(draw(around), picture);
  EXPECT_EQ(draw(hierarchy + "/hierarchy.json"), picture);
  EXPECT_THAT(complaint_of(run_recede({"render", folder.path(), "-o", folder / "b.png"}), 1),
              HasSubstr("holds no hierarchy"));
}

TEST(RenderCommand, DrawsTheLevelThatTheViewNeeds) {
  const TempFolder folder;
  const std::string hierarchy = bake_sphere(folder);
  const auto draw = [&](const char* distance, std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"render",
                                       hierarchy,
                                       "-o",
                                       folder / "a.png",
                                       "--image-width",
                                       "60",
                                       "--image-height",
                                       "40",
                                       "--samples",
                                       "1",
                                       "--eye",
                                       "0",
                                       "0",
                                       distance,
                                       "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return json_of(run_recede(arguments));
  };
  EXPECT_EQ(draw("1.5").at("level"), 0);
  EXPECT_EQ(draw("1000").at("level"), 2);
  EXPECT_EQ(draw("1000", {"--level", "1"}).at("level"), 1);
  EXPECT_LE(draw("4", {"--pixel-error", "50"}).at("faces").get<int>(), 120);
  EXPECT_EQ(size_of(folder / "a.png"), (std::pair<unsigned, unsigned>(60, 40)));
}

TEST(RenderCommand, DrawsMeshesAndBuiltInModels) {
  const TempFolder folder;
  const json result = json_of(run_recede({"render", "teapot", "-o", folder / "t.png", "--flat", "--wireframe",
                                          "--samples", "1", "--image-width", "50", "--json"}));
  EXPECT_EQ(result.at("level"), 0);
  EXPECT_EQ(size_of(folder / "t.png"), (std::pair<unsigned, unsigned>(50, 600)));
}

TEST(RenderCommand, ShowsErrorsAndLevelsAsColours) {
  const TempFolder folder;
  const std::string hierarchy = bake_sphere(folder);
  const auto middle = [&](const char* color, const char* level) {
    const auto run =
        run_recede({"render", hierarchy, "-o", folder / "a.png", "--image-width", "21", "--image-height",
                    "21", "--level", level, "--false-color", color, "--samples", "4"});
    EXPECT_EQ(run.code, 0) << run.remarks;
    const Raster picture = read_png(folder / "a.png");
    return picture.at(10, 10, 0) + picture.at(10, 10, 1) + picture.at(10, 10, 2);
  };
  EXPECT_LT(middle("level", "0"), middle("level", "1"));
  EXPECT_LT(middle("level", "1"), middle("level", "2"));
  EXPECT_LT(middle("error", "0"), 60) << "nothing differs from the input";
  EXPECT_GT(middle("error", "2"), middle("error", "0"));
  EXPECT_THAT(
      complaint_of(run_recede({"render", hierarchy, "-o", folder / "b.png", "--false-color", "mood"}), 2),
      HasSubstr("--false-color"));
}

TEST(RenderCommand, ChoosesLevelsByTheShareOfTheirFaces) {
  const TempFolder folder;
  const std::string hierarchy = bake_sphere(folder);  // 30 and 5 % of the faces
  const auto level = [&](const char* distance, const char* near_limit = "0") {
    return json_of(run_recede({"render",
                               hierarchy,
                               "-o",
                               folder / "a.png",
                               "--image-width",
                               "8",
                               "--image-height",
                               "8",
                               "--samples",
                               "1",
                               "--level-rule",
                               "distance",
                               "--distance-unit",
                               "1",
                               "--near-limit",
                               near_limit,
                               "--eye",
                               "0",
                               "0",
                               distance,
                               "--look-at",
                               "0",
                               "0",
                               "0",
                               "--json"}))
        .at("level")
        .get<int>();
  };
  // Distances count from the bounding sphere, whose radius is some 1.1.
  EXPECT_EQ(level("3"), 0);
  EXPECT_EQ(level("8"), 1);
  EXPECT_EQ(level("30"), 2);
  EXPECT_EQ(level("1.2", "1"), 2);
}

/// A small picture of a sphere, whose options are given.
json draw_sphere(const TempFolder& folder, const std::string& file, const std::vector<std::string>& more) {
  std::vector<std::string> arguments{
      "render", write_sphere(folder, 200), "-o", folder / file, "--image-width",
      "24",     "--image-height",          "24", "--json"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return json_of(run_recede(arguments));
}

TEST(RenderCommand, LightsTheSceneByItsOwnLights) {
  const TempFolder folder;
  const auto picture = [&](const std::vector<std::string>& more) {
    draw_sphere(folder, "a.exr", more);
    return read_image(folder / "a.exr");
  };
  const Image camera = picture({}), path = picture({"--lighting", "path", "--ground"});
  EXPECT_FALSE(path.pixels == camera.pixels);
  EXPECT_TRUE(path.pixels == picture({"--lighting", "path", "--ground", "--threads", "1"}).pixels);
  EXPECT_FALSE(path.pixels == picture({"--lighting", "path", "--ground", "--bounces", "0"}).pixels);
  // A lamp without blue leaves nothing blue.
  const Image lamps = picture({"--lighting", "direct", "--ambient", "0", "--lamp", "0", "0", "3", "2", "1",
                               "0", "--lamp", "3", "3", "3", "2", "1", "0"});
  EXPECT_EQ(lamps.at(12, 12).z(), 0);
  EXPECT_NEAR(lamps.at(12, 12).x(), 2 * lamps.at(12, 12).y(), 1e-5f);
  const Image area = picture({"--lighting", "direct", "--ambient", "0", "--area", "-1", "-1", "3", "0", "2",
                              "0", "2", "0", "0", "0", "0", "5", "--light-sampling", "lights"});
  EXPECT_GT(area.at(12, 12).z(), 0.1f);
  EXPECT_EQ(area.at(12, 12).x(), 0);
  const Image sun = picture({"--lighting", "direct", "--ambient", "0", "--sun", "0", "0", "-1", "--sun-color",
                             "9", "9", "9", "--sun-size", "0"});
  EXPECT_EQ(sun.at(12, 12).x(), 0) << "it shines from behind";
}

TEST(RenderCommand, LightsTheSceneByAPictureOfDirections) {
  const TempFolder folder;
  const std::string sky = folder / "sky.exr";
  write_image(sky, Image(4, 2, Rgb(0.5f, 0.25f, 0.125f)));
  const auto corner = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"--lighting", "path", "--environment", sky};
    arguments.insert(arguments.end(), more.begin(), more.end());
    draw_sphere(folder, "a.exr", arguments);
    return read_image(folder / "a.exr").at(0, 0);
  };
  EXPECT_TRUE(corner({}).isApprox(Rgb(0.5f, 0.25f, 0.125f), 1e-6f));
  EXPECT_TRUE(corner({"--environment-scale", "2", "--environment-rotation", "90"})
                  .isApprox(Rgb(1, 0.5f, 0.25f), 1e-6f));
  EXPECT_TRUE(corner({"--hide-environment"}).isApprox(RenderOptions{}.background));
  Image broken(4, 2);
  broken.at(3, 1).x() = std::numeric_limits<float>::infinity();
  write_image(sky, broken);
  const std::string complaint = complaint_of(
      run_recede({"render", "sphere", "-o", folder / "b.png", "--lighting", "path", "--environment", sky}),
      1);
  EXPECT_THAT(complaint, HasSubstr("sky.exr"));
  EXPECT_THAT(complaint, HasSubstr("column 3, row 1"));
}

TEST(RenderCommand, ShowsWhereSamplesWent) {
  const TempFolder folder;
  draw_sphere(folder, "a.png",
              {"--lighting", "path", "--noise", "0.02", "--samples", "256", "--false-color", "samples"});
  const Raster picture = read_png(folder / "a.png");
  const auto brightness = [&](int x, int y) {
    return picture.at(x, y, 0) + picture.at(x, y, 1) + picture.at(x, y, 2);
  };
  EXPECT_LT(brightness(0, 0), brightness(12, 18)) << "the background needs fewest";
}

TEST(RenderCommand, RefusesLightsThatCannotBe) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 100), out = folder / "a.png";
  const auto complaint = [&](const std::vector<std::string>& more, int code = 2) {
    std::vector<std::string> arguments{"render", sphere, "-o", out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return complaint_of(run_recede(arguments), code);
  };
  EXPECT_THAT(complaint({"--sun", "0", "1", "0"}), HasSubstr("--sun needs --lighting"));
  EXPECT_THAT(complaint({"--bounces", "2"}), HasSubstr("--bounces needs --lighting"));
  EXPECT_THAT(complaint({"--lighting", "moon"}), HasSubstr("--lighting"));
  EXPECT_THAT(complaint({"--lighting", "path", "--sun", "0", "0", "0"}), HasSubstr("direction"));
  EXPECT_THAT(complaint({"--lighting", "path", "--lamp", "0", "0", "0", "1", "-1", "0"}),
              HasSubstr("intensity"));
  EXPECT_THAT(complaint({"--lighting", "path", "--lamp", "0", "0", "0"}), HasSubstr("--lamp"));
  EXPECT_THAT(
      complaint({"--lighting", "path", "--area", "0", "0", "0", "1", "0", "0", "1", "0", "0", "1", "1", "1"}),
      HasSubstr("area"));
  EXPECT_THAT(complaint({"--lighting", "path", "--environment", folder / "no.exr"}, 1), HasSubstr("no.exr"));
  EXPECT_THAT(complaint({"--lighting", "path", "--environment-scale", "2"}), HasSubstr("--environment"));
  EXPECT_THAT(complaint({"--lighting", "path", "--bounces", "-1"}), HasSubstr("--bounces"));
  EXPECT_THAT(complaint({"--samples", "2000"}), HasSubstr("1024"));
  EXPECT_THAT(complaint({"--false-color", "samples"}), HasSubstr("--noise"));
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(RenderCommand, SetsTheTeapotUpright) {
  const TempFolder folder;
  const auto eye = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments{"render", "teapot",        "-o", folder / "t.png", "--samples",
                                       "1",      "--image-width", "8",  "--image-height", "8",
                                       "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return json_of(run_recede(arguments)).at("eye");
  };
  EXPECT_EQ(eye({}), eye({"--up", "z"}));
  EXPECT_NE(eye({}), eye({"--up", "y"}));
}

TEST(RenderCommand, RefusesWhatItCannotDraw) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 100), out = folder / "a.png";
  EXPECT_THAT(complaint_of(run_recede({"render", sphere, "-o", folder / "a.jpg"}), 1), HasSubstr(".png"));
  EXPECT_THAT(complaint_of(run_recede({"render", sphere, "-o", out, "--level", "1"}), 2),
              HasSubstr("level 1"));
  EXPECT_THAT(complaint_of(run_recede({"render", sphere, "-o", out, "--image-width", "0"}), 2),
              HasSubstr("--image-width"));
  EXPECT_THAT(
      complaint_of(
          run_recede({"render", sphere, "-o", out, "--eye", "0", "0", "0", "--look-at", "0", "0", "0"}), 2),
      HasSubstr("apart"));
  EXPECT_THAT(complaint_of(run_recede({"render", folder / "nothing.recede", "-o", out}), 1),
              HasSubstr("nothing"));
  EXPECT_THAT(complaint_of(run_recede({"render", sphere, "-o", out, "--false-color", "error"}), 2),
              HasSubstr("one level"));
  EXPECT_THAT(complaint_of(run_recede({"render", sphere, "-o", folder / "no" / "a.png"}), 1),
              HasSubstr("no folder"));
  EXPECT_THAT(complaint_of(run_recede({"turntable", sphere, "-o", sphere}), 1), HasSubstr("isn't a folder"));
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(TurntableCommand, SaysWhereTheLevelChanges) {
  const TempFolder folder;
  const CommandResult run =
      run_recede({"turntable", bake_sphere(folder), "-o", folder / "frames", "--frames", "3", "--eye",
                  "0,0,1.5", "--pixel-error", "0.02", "--until-distance", "1000", "--samples", "1",
                  "--image-width", "8", "--image-height", "8"});
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.output, testing::ContainsRegex(
                              "frames       3 in .*\nfrom    0    level 0, 20[0-9][0-9] faces\nfrom "));
}

TEST(RenderCommand, SaysWhatReadingRepairedAndWhichMethodsItTook) {
  const TempFolder folder;
  const std::string square = folder.write("square.obj",
                                          "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 0\nvt 0 0\nvt 1 0\nvt 1 "
                                          "1\nvt 0 1\nf 1/1 2/2 3/3\nf 5/1 3/3 4/4\n");
  Raster heights{.width = 8, .height = 8, .channels = 1, .bits = 8, .srgb = false, .samples = {}};
  for (int k = 0; k < 64; ++k) heights.samples.push_back(static_cast<std::uint16_t>(k % 2 * 200));
  const std::string map = folder.write("map.png", encode_png(heights));
  const auto draw = [&](std::vector<std::string> more) {
    more.insert(more.begin(),
                {"render", square, "-o", folder / "a.png", "--image-width", "8", "--image-height", "8"});
    const CommandResult run = run_recede(more);
    EXPECT_EQ(run.code, 0) << run.remarks;
    return run;
  };
  EXPECT_THAT(draw({}).remarks, HasSubstr("recede: merge_identical_vertices: "));
  EXPECT_THAT(
      draw({"--displacement-map", map, "--displacement-scale", "0.01", "--appearance", "bump"}).output,
      testing::ContainsRegex("methods      bump [0-9.]+ %\n"));
}

TEST(RenderCommand, DrawsWhatIsUnderAShellWithoutItsTexture) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 300), shell = folder / "a.shell";
  ASSERT_EQ(run_recede({"shell", sphere, "-o", shell, "--thickness", "0.1", "--texture", "chain-mail",
                        "--texels", "8"})
                .code,
            0);
  const auto draw = [&](const std::string& input, std::vector<std::string> more) {
    more.insert(more.begin(),
                {"render", input, "-o", folder / "a.exr", "--image-width", "32", "--image-height", "32"});
    const CommandResult run = run_recede(more);
    EXPECT_EQ(run.code, 0) << run.remarks;
    return read_image(folder / "a.exr");
  };
  const Image bare = draw(shell, {"--no-maps"});
  EXPECT_LT(compare_images(bare, draw(sphere, {})).rmse, 0.01);
  EXPECT_GT(compare_images(bare, draw(shell, {})).rmse, 0.02);
}

TEST(TurntableCommand, GoesAwayOverTheLevels) {
  const TempFolder folder;
  const json result = json_of(run_recede({"turntable",
                                          bake_sphere(folder),
                                          "-o",
                                          folder / "frames",
                                          "--frames",
                                          "6",
                                          "--eye",
                                          "0",
                                          "0",
                                          "1.5",
                                          "--look-at",
                                          "0",
                                          "0",
                                          "0",
                                          "--pixel-error",
                                          "0.02",
                                          "--until-distance",
                                          "1000",
                                          "--turn",
                                          "90",
                                          "--samples",
                                          "1",
                                          "--image-width",
                                          "20",
                                          "--image-height",
                                          "20",
                                          "--json"}));
  const json& frames = result.at("frames");
  ASSERT_EQ(frames.size(), 6u);
  EXPECT_EQ(frames.front().at("level"), 0);
  EXPECT_EQ(frames.back().at("level"), 2);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_TRUE(std::filesystem::exists(frames[i].at("file").get<std::string>()));
    if (i > 0) {
      EXPECT_GE(frames[i].at("level"), frames[i - 1].at("level"));
    }
  }
  // Five sixths of the turn are done; what is left is rounding of products and of a power.
  const json& eye = frames.back().at("eye");
  const Vec3 at(eye[0], eye[1], eye[2]);
  EXPECT_NEAR(at.norm(), 1000, 1e-9);
  EXPECT_NEAR(std::atan2(at.x(), at.z()), 75 * std::numbers::pi / 180, 1e-12);
}

TEST(RenderCommand, DrawsHeightsByEveryMethodAlike) {
  const TempFolder folder;
  const auto baked = run_recede({"bake", write_sphere(folder, 4000), "-o", folder / "out", "--no-report",
                                 "--ratios", "0.05", "--maps", "displacement,normal", "--map-size", "128"});
  ASSERT_EQ(baked.code, 0) << baked.remarks;
  const auto draw = [&](const std::string& method) {
    const json result = json_of(
        run_recede({"render", folder / "out" / "sphere.recede", "-o", folder / (method + ".png"), "--level",
                    "1", "--image-width", "80", "--image-height", "80", "--displacement", method, "--json"}));
    EXPECT_EQ(result.at("displacement"), method);
    return read_image(folder / (method + ".png"));
  };
  const Image bare = draw("none"), reference = draw("tessellated");
  const double without = compare_images(bare, reference).rmse;
  EXPECT_GT(without, 0.01);
  EXPECT_LT(compare_images(draw("traced"), reference).rmse, 0.3 * without);
  EXPECT_LT(compare_images(draw("diced"), reference).rmse, without);
}

TEST(RenderCommand, DrawsAMeshWithAHeightMapInAFile) {
  const TempFolder folder;
  PolygonSoup square;
  square.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  square.add_face(std::array<Index, 4>{0, 1, 2, 3});
  square.corner_uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  write_soup(folder / "square.obj", square);
  Raster heights;
  heights.width = heights.height = 16;
  for (int k = 0; k < 256; ++k) heights.samples.push_back(static_cast<std::uint16_t>(k % 16 < 8 ? 0 : 255));
  folder.write("heights.png", encode_png(heights));
  const auto draw = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments{
        "render", folder / "square.obj", "-o", folder / "a.png", "--image-width",
        "64",     "--image-height",      "64", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_recede(arguments);
  };
  const auto traced = draw({"--displacement-map", folder / "heights.png", "--displacement-scale", "0.3",
                            "--subdivision-level", "5"});
  EXPECT_EQ(json_of(traced).at("displacement"), "traced");
  EXPECT_EQ(json_of(traced).at("faces"), 1);
  const Image with = read_image(folder / "a.png");
  EXPECT_EQ(json_of(draw({})).at("displacement"), "none");
  EXPECT_GT(compare_images(with, read_image(folder / "a.png")).rmse, 0.02);
  const auto green = draw({"--displacement-map", folder / "heights.png", "--false-color", "method"});
  ASSERT_EQ(green.code, 0) << green.remarks;
  const Image method = read_image(folder / "a.png");
  EXPECT_GT(method.at(32, 20)[1], 2 * method.at(32, 20)[0]);

  EXPECT_THAT(draw({"--displacement-map", folder / "nowhere.png"}).remarks, HasSubstr("nowhere.png"));
  EXPECT_EQ(draw({"--displacement-map", folder / "nowhere.png"}).code, 1);
  EXPECT_EQ(draw({"--displacement", "magic"}).code, 2);
  EXPECT_EQ(draw({"--subdivision-level", "15"}).code, 2);
}

}  // namespace
}  // namespace recede::test
