// The report as a person sees it: opened by a real browser without a network.
#include "run_recede.h"
#include "temp_folder.h"
#include <recede/geometry/atomic_file.h>

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

/// Bakes the teapot's levels into `out` below the folder; returns the page's address.
std::string bake_teapot(const test::TempFolder& folder, const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"bake", "teapot", "-o", folder / "out"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  EXPECT_EQ(test::run_recede(arguments).code, 0);
  return fmt::format("file://{}", (folder / "out/report.html").string());
}

TEST(ReportInABrowser, ShowsEveryLevel) {
  if (!has_program("chromium")) GTEST_SKIP() << "chromium isn't installed";
  const test::TempFolder folder;
  const std::string page = fmt::format("'{}'", bake_teapot(folder, {"--ratios", "0.1", "0.01"}));
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
  const std::string page = bake_teapot(
      folder, {"--ratios", "0.5", "0.1", "0.01", "--maps", "normal,displacement", "--map-size", "256"});
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
  for (const auto& [name, step] : steps.items()) {
    EXPECT_EQ(step.at("broken"), 0) << name << ": pictures that don't load";
    EXPECT_LE(step.at("overflow"), 0) << name << ": wider than the window";
  }
}

}  // namespace
}  // namespace recede
