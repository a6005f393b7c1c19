// The report as a person sees it: opened by a real browser without a network.
#include "run_recede.h"
#include "temp_folder.h"
#include <recede/geometry/atomic_file.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace recede {
namespace {

using ::testing::HasSubstr;
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

TEST(ReportInABrowser, ShowsEveryLevelAndLogsNoError) {
  if (std::system("command -v chromium >/dev/null 2>&1") != 0) GTEST_SKIP() << "chromium isn't installed";
  const test::TempFolder folder;
  const std::string out = folder / "out";
  ASSERT_EQ(test::run_recede({"bake", "teapot", "-o", out, "--ratios", "0.1", "0.01"}).code, 0);
  const std::string page = "'file://" + out + "/report.html'";
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

}  // namespace
}  // namespace recede
