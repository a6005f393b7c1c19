// What happens on a terminal: the progress bar, and Ctrl-C. The bar says when work has got to the place where
// Ctrl-C is to strike, so that nothing here waits for a clock.
#include "run_recede.h"

namespace recede::test {
namespace {

using testing::Contains;
using testing::Each;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr const char* k_clear_line = "\r\x1b[K";

TEST(Terminal, ShowsAProgressBarAndWipesItBeforeTheResults) {
  const TempFolder folder;
  const CommandResult run = run_recede_on_terminal(
      {"simplify", write_sphere(folder, 20000), "-o", folder / "small.ply", "--ratio", "0.1"}, "");
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.output, HasSubstr(" % simplify"));
  const std::string after_bar =
      run.output.substr(run.output.rfind(k_clear_line) + std::string(k_clear_line).size());
  EXPECT_THAT(after_bar, testing::StartsWith("faces "));
}

TEST(Terminal, ShowsNoBarWhenQuiet) {
  const TempFolder folder;
  const CommandResult run = run_recede_on_terminal(
      {"simplify", write_sphere(folder, 2000), "-o", folder / "small.ply", "--ratio", "0.1", "--quiet"}, "");
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.output, Not(HasSubstr("\x1b")));
}

/// Bakes a sphere and presses Ctrl-C when the bar shows `stage`.
CommandResult interrupt_bake(const TempFolder& folder, const std::string& stage) {
  const TempFolder inputs;
  CommandResult run = run_recede_on_terminal(
      {"bake", write_sphere(inputs, 20000), "-o", folder / "out", "--ratios", "0.3", "0.02"}, stage);
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.output, HasSubstr(stage));
  EXPECT_THAT(run.output, EndsWith(std::string(k_clear_line) + "recede: cancelled\r\n"));
  return run;
}

TEST(Interrupt, LeavesNothingWhenItComesWhileSimplifying) {
  const TempFolder folder;
  interrupt_bake(folder, "% simplify");
  EXPECT_THAT(names_below(folder / ""), IsEmpty());
}

TEST(Interrupt, LeavesNothingWhenItComesWhileMeasuring) {
  const TempFolder folder;
  interrupt_bake(folder, "level 1: measure");
  EXPECT_THAT(names_below(folder / ""), IsEmpty());
}

TEST(Interrupt, LeavesTheWholeHierarchyWhenItComesWhileDrawingTheReport) {
  const TempFolder folder;
  interrupt_bake(folder, "draw report");
  const std::vector<std::string> names = names_below(folder / "out");
  EXPECT_THAT(names, Contains("sphere.glb"));
  EXPECT_THAT(names, Contains("sphere.recede/hierarchy.json"));
  EXPECT_THAT(names, Each(Not(HasSubstr(".part"))));
  EXPECT_THAT(names, Not(Contains("report.html")));
  EXPECT_EQ(run_recede({"info", folder / "out/sphere.recede/level_2.ply"}).code, 0);
}

TEST(Interrupt, StopsSimplifyWithoutAFile) {
  const TempFolder folder;
  const CommandResult run = run_recede_on_terminal(
      {"simplify", "sphere", "-o", folder / "small.ply", "--ratio", "0.01"}, "% simplify");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.output, EndsWith("recede: cancelled\r\n"));
  EXPECT_THAT(names_below(folder / ""), IsEmpty());
}

TEST(Interrupt, StopsCompare) {
  const CommandResult run = run_recede_on_terminal({"compare", "sphere", "teapot"}, "% measure");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.output, EndsWith("recede: cancelled\r\n"));
}

}  // namespace
}  // namespace recede::test
