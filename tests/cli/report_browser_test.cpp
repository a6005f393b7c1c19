// The report as a person sees it: opened by a real browser without a network.
#include "run_recede.h"
#include "temp_folder.h"
#include <recede/geometry/atomic_file.h>
#include <recede/render/detail/markup.h>
#include <recede/render/image_difference.h>
#include <recede/render/image_io.h>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <filesystem>

namespace recede {
namespace {

using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// Runs headless Chromium with a profile below `folder`; the flags keep it from looking for a network.
int browse(const test::TempFolder& folder, const std::string& arguments) {
  const std::string command =
      "chromium --headless --no-sandbox --disable-gpu --disable-quic --no-first-run "
      "--disable-component-update "
      "--disable-background-networking --disable-sync --user-data-dir='" +
      (folder / "profile").string() + "' " + arguments + " 2>/dev/null";
  return std::system(command.c_str());
}

bool has_program(const std::string& name) {
  return std::system(fmt::format("command -v {} >/dev/null 2>&1", name).c_str()) == 0;
}

/// Bakes levels of a model into `out` below the folder; returns the page's address.
std::string bake(const test::TempFolder& folder, const std::string& model,
                 const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"bake", model, "-o", folder / "out"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  EXPECT_EQ(test::run_recede(arguments).code, 0);
  return fmt::format("file://{}", (folder / "out/report.html").string());
}

bool has_viewer(const test::TempFolder& folder) {
  return read_whole_file(folder / "out/report.html").find("id=\"viewer-canvas\"") != std::string::npos;
}

TEST(ReportInABrowser, ShowsEveryLevel) {
  if (!has_program("chromium")) GTEST_SKIP() << "chromium isn't installed";
  const test::TempFolder folder;
  const std::string page = fmt::format("'{}'", bake(folder, "teapot", {"--ratios", "0.1", "0.01"}));
  const std::string dom = folder / "dom.html", picture = folder / "report.png";
  ASSERT_EQ(browse(folder, "--dump-dom " + page + " > '" + dom + "'"), 0);
  const std::string text = read_whole_file(dom);
  for (const char* level : {"Level 0", "Level 1", "Level 2"}) EXPECT_THAT(text, HasSubstr(level));
  EXPECT_THAT(text, HasSubstr("<svg"));
  EXPECT_THAT(text, Not(HasSubstr("src=\"http")));
  ASSERT_EQ(browse(folder, "--window-size=1200,2400 --screenshot='" + picture + "' " + page + " >/dev/null"),
            0);
  // An empty page of this size is some 10 kB as a PNG; one with renderings is far larger.
  EXPECT_GT(std::filesystem::file_size(picture), 100'000u);
}

TEST(ReportInABrowser, GoesThroughTheLevelsByKeysAndListsThemAllWithoutScripts) {
  if (!has_program("chromium") || !has_program("node")) GTEST_SKIP() << "needs chromium and node";
  const test::TempFolder folder;
  const std::string page =
      bake(folder, "teapot",
           {"--ratios", "0.5", "0.1", "0.01", "--maps", "normal,displacement", "--map-size", "256"});
  const std::string answer = folder / "answer.json";
  const std::string command = fmt::format("node '{}' '{}' '{}' > '{}'", RECEDE_USE_REPORT, page,
                                          (folder / "profile").string(), answer);
  ASSERT_EQ(std::system(command.c_str()), 0);
  const nlohmann::json found = nlohmann::json::parse(read_whole_file(answer));
  EXPECT_THAT(found.at("errors"), IsEmpty());

  // What a level's title must be, by what the command says of it.
  std::vector<std::string> titles;
  const auto report = nlohmann::json::parse(read_whole_file(folder / "out/report.json"));
  for (const auto& level : report.at("levels")) {
    titles.push_back(
        fmt::format("Level {}: {} faces", level.at("level").get<int>(), level.at("faces").get<int>()));
  }
  ASSERT_EQ(titles.size(), 4u);
  const auto& steps = found.at("steps");
  const auto expect_one = [&](const char* step, std::size_t level) {
    EXPECT_THAT(steps.at(step).at("titles"), ElementsAre(titles[level])) << step;
    EXPECT_EQ(steps.at(step).at("text"), titles[level]) << step;
    EXPECT_EQ(steps.at(step).at("spoken"), titles[level]) << step;
  };
  expect_one("opened", 1);
  expect_one("reached", 1);
  EXPECT_EQ(steps.at("reached").at("focus"), "level") << "the tabulator key reaches the slider";
  expect_one("right", 2);
  expect_one("home", 0);
  expect_one("end", 3);
  EXPECT_THAT(steps.at("all").at("titles"), ElementsAreArray(titles));
  expect_one("link", 1);
  for (const char* step : {"printed", "without_scripts"}) {
    EXPECT_THAT(steps.at(step).at("titles"), ElementsAreArray(titles)) << step;
    EXPECT_FALSE(steps.at(step).at("slider").get<bool>()) << step;
  }
  if (has_viewer(folder)) {
    EXPECT_THAT(steps.at("opened").at("no_viewer").get<std::string>(), HasSubstr("needs WebGL"));
    EXPECT_THAT(steps.at("without_scripts").at("no_viewer").get<std::string>(), HasSubstr("needs scripts"));
  }
  for (const auto& [name, step] : steps.items()) {
    EXPECT_EQ(step.at("broken"), 0) << name << ": pictures that don't load";
    EXPECT_LE(step.at("overflow"), 0) << name << ": wider than the window";
  }
}

/// Share of the pixels from column `from` to `to`, shares of the width, that show the model.
double model_share(const Image& picture, double from = 0, double to = 1) {
  const Rgb background = picture.at(picture.width / 10, picture.height / 10);
  const int first = static_cast<int>(from * picture.width), last = static_cast<int>(to * picture.width);
  int count = 0;
  for (int y = 0; y < picture.height; ++y) {
    // More than what a browser's conversion of colours may change.
    for (int x = first; x < last; ++x) count += (picture.at(x, y) - background).cwiseAbs().maxCoeff() > 0.02f;
  }
  return static_cast<double>(count) / (static_cast<double>(last - first) * picture.height);
}

/// What the viewer shows at each step, see use_viewer.cjs; pictures of the steps are in the folder.
nlohmann::json use_viewer(const test::TempFolder& folder, const std::string& page) {
  const std::string answer = folder / "answer.json";
  const std::string command = fmt::format("node '{}' '{}' '{}' '{}' > '{}'", RECEDE_USE_VIEWER, page,
                                          (folder / "profile").string(), folder.path().string(), answer);
  EXPECT_EQ(std::system(command.c_str()), 0);
  return nlohmann::json::parse(read_whole_file(answer));
}

TEST(ReportInABrowser, TheViewerShowsLevelsAsTheyAreAndAsDistancesChooseThem) {
  if (!has_program("chromium") || !has_program("node")) GTEST_SKIP() << "needs chromium and node";
  const test::TempFolder folder;
  const std::string page = bake(folder, "teapot", {"--ratios", "0.1", "0.01"});
  if (!has_viewer(folder)) GTEST_SKIP() << "built without the viewer";
  const nlohmann::json found = use_viewer(folder, page);
  EXPECT_THAT(found.at("errors"), IsEmpty());
  EXPECT_THAT(found.at("requests"), IsEmpty());
  const auto& steps = found.at("steps");
  EXPECT_TRUE(steps.at("opened").at("seen").get<bool>());
  EXPECT_FALSE(steps.at("opened").at("absent").get<bool>());
  EXPECT_EQ(steps.at("opened").at("unlabelled"), 0);

  const auto levels = nlohmann::json::parse(read_whole_file(folder / "out/report.json")).at("levels");
  ASSERT_EQ(levels.size(), 3u);
  std::vector<std::string> titles;
  for (const auto& level : levels) {
    ASSERT_EQ(level.at("larger_polygons"), 0);
    titles.push_back(fmt::format("Level {}: {} triangles", titles.size(),
                                 level.at("triangles").get<int>() + 2 * level.at("quads").get<int>()));
  }
  std::size_t distances = 0;
  for (const auto& [name, step] : steps.items()) {
    if (name.rfind("distance-", 0) != 0) continue;
    ++distances;
    std::size_t serves = 0;
    for (std::size_t i = 0; i < levels.size(); ++i) {
      if (levels[i].at("switch_distance") <= step.at("distance")) serves = i;
    }
    EXPECT_EQ(step.at("shown"), titles[serves]) << name;
    EXPECT_THAT(step.at("at").get<std::string>(), HasSubstr(fmt::format("level {} serves", serves)));
    EXPECT_TRUE(step.at("follows").get<bool>());
  }
  EXPECT_EQ(distances, 4u);
  EXPECT_EQ(steps.at("distance-0").at("shown"), titles[0]);
  EXPECT_EQ(steps.at("distance-1").at("shown"), titles[2]);

  const auto picture = [&](const std::string& step) { return read_image(folder / (step + ".png")); };
  const auto differ = [&](const std::string& a, const std::string& b) {
    return compare_images(picture(a), picture(b)).changed_share;
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string step = fmt::format("level-{}", i);
    EXPECT_EQ(steps.at(step).at("shown"), titles[i]);
    EXPECT_FALSE(steps.at(step).at("follows").get<bool>());
    EXPECT_GT(model_share(picture(step)), 0.1) << step;
    EXPECT_LT(model_share(picture(step)), 0.9) << step;
  }
  EXPECT_GT(differ("level-0", "level-2"), 0.01);
  // A level of some hundred triangles has lines all over, and colours where it is off.
  EXPECT_GT(differ("wireframe", "level-2"), 0.02);
  EXPECT_GT(differ("error", "level-2"), 0.02);
  EXPECT_TRUE(steps.at("error").at("legend").get<bool>());
  EXPECT_FALSE(steps.at("wireframe").at("legend").get<bool>());
  EXPECT_THAT(steps.at("error").at("most").get<std::string>(), HasSubstr(" object units ("));
  EXPECT_EQ(steps.at("beside").at("left"), titles[2]);
  EXPECT_EQ(steps.at("beside").at("right"), titles[0] + ", the input");
  EXPECT_GT(model_share(picture("beside"), 0, 0.5), 0.1);
  EXPECT_GT(model_share(picture("beside"), 0.5, 1), 0.1);
  EXPECT_EQ(differ("again", "level-2"), 0);
  for (const char* step : {"turned", "zoomed", "dragged"}) EXPECT_GT(differ(step, "again"), 0.02) << step;
  EXPECT_GT(differ("dragged", "zoomed"), 0.02);
  EXPECT_GT(model_share(picture("zoomed")), 1.2 * model_share(picture("turned")));
  EXPECT_EQ(differ("reset", "again"), 0);
  EXPECT_GT(model_share(picture("true-size")), 0);
  EXPECT_LT(model_share(picture("true-size")), 0.01);

  const auto& plots = found.at("plots");
  const auto bound_of = [&](std::size_t level) {
    return fmt::format("certified bound: faces {}, error (object units) {}",
                       levels[level].at("faces").get<int>(),
                       detail::short_number(levels[level].at("error").at("bound").get<double>()));
  };
  EXPECT_THAT(plots.at("pointer"), ElementsAre(bound_of(1)));
  EXPECT_THAT(plots.at("away"), IsEmpty());
  EXPECT_THAT(plots.at("focus"), ElementsAre(bound_of(1)));
  EXPECT_THAT(plots.at("right"), ElementsAre(bound_of(2)));
  const std::string last =
      fmt::format("RMS: faces {}, error (object units) {}", levels[2].at("faces").get<int>(),
                  detail::short_number(levels[2].at("error").at("rms").get<double>()));
  EXPECT_THAT(plots.at("end"), ElementsAre(last));
  EXPECT_EQ(plots.at("spoken"), last);
}

TEST(ReportInABrowser, TheViewerShowsBillboardsAsTheModelLooks) {
  if (!has_program("chromium") || !has_program("node")) GTEST_SKIP() << "needs chromium and node";
  const test::TempFolder folder;
  const std::string page = bake(folder, "tree", {"--ratios", "0.3"});
  if (!has_viewer(folder)) GTEST_SKIP() << "built without the viewer";
  const nlohmann::json found = use_viewer(folder, page);
  EXPECT_THAT(found.at("errors"), IsEmpty());
  EXPECT_THAT(found.at("requests"), IsEmpty());
  const auto& steps = found.at("steps");
  EXPECT_THAT(steps.at("level-1").at("shown").get<std::string>(), HasSubstr(" billboards"));
  EXPECT_EQ(steps.at("error").at("most"), "billboards show their colours");
  const auto picture = [&](const std::string& step) { return read_image(folder / (step + ".png")); };
  const double tree = model_share(picture("level-0")), billboards = model_share(picture("level-1"));
  // Measured 0.91, and 1.94 where whole rectangles are drawn; FLIP 0.051 and 0.128.
  EXPECT_NEAR(billboards / tree, 1, 0.2) << tree;
  EXPECT_LT(compute_flip(picture("level-0"), picture("level-1")).mean, 0.06);
}

}  // namespace
}  // namespace recede
