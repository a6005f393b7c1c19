// `recede render` and `recede turntable` on meshes and on what `recede bake` wrote.
#include "run_recede.h"
#include <recede/geometry/raster.h>

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
  EXPECT_NEAR(std::atan2(at.x(), at.z()), 75 * 3.14159265358979 / 180, 1e-12);
}

}  // namespace
}  // namespace recede::test
