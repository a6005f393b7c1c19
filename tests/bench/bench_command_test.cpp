#include "bench_command.h"

#include "plot_sheet.h"
#include "temp_folder.h"
#include <recede/geometry/error.h>

#include <gmock/gmock.h>

#include <csignal>
#include <fstream>
#include <iterator>

namespace recede::bench {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

ReportSection section_of(const std::string& name, const std::string& markdown) {
  return {name, "Title of " + name, "What " + name + " compares.",
          [markdown](const BenchOptions&) { return BenchSection{.markdown = markdown}; }};
}

ReportSection with_curve(ReportSection section) {
  section.measure = [](const BenchOptions&) {
    Plot plot = log_plot("a curve", "x", "y");
    add_point(plot, "ours", 1, 2);
    return BenchSection{.curves = {plot}};
  };
  return section;
}

/// The exit code of a run into the folder.
int run(const std::vector<ReportSection>& sections, const test::TempFolder& folder,
        std::vector<const char*> arguments = {}) {
  const std::string out = folder.path().string();
  arguments.insert(arguments.begin(), {"recede_bench", "--out", out.c_str()});
  return run_bench_command(sections, static_cast<int>(arguments.size()), arguments.data());
}

TEST(BenchCommand, WritesAllSectionsInTheirOrder) {
  const test::TempFolder folder;
  EXPECT_EQ(run({section_of("b", "## Table\n\n| 1 |\n"), with_curve(section_of("a", "")),
                 section_of("c", "| 3 |\n")},
                folder),
            0);
  const std::string report = content_of(folder / "report.md");
  const std::size_t b = report.find("## Title of b\n\nWhat b compares.\n"),
                    table = report.find("\n### Table\n\n| 1 |\n"), a = report.find("## Title of a\n"),
                    curves = report.find("(report-a.svg)"), c = report.find("## Title of c\n");
  ASSERT_NE(c, std::string::npos);
  EXPECT_LT(b, table);
  EXPECT_LT(table, a);
  EXPECT_LT(a, curves);
  EXPECT_LT(curves, c);
  EXPECT_THAT(content_of(folder / "report-a.svg"), HasSubstr("a curve"));
  EXPECT_FALSE(std::filesystem::exists(folder / "report-b.svg"));
}

TEST(BenchCommand, ASectionThatFailsIsToldAndLosesNoOther) {
  ReportSection refused = section_of("refused", ""), crashed = section_of("crashed", "");
  refused.measure = [](const BenchOptions&) -> BenchSection { throw InputError("a model\nis missing"); };
  crashed.measure = [](const BenchOptions&) -> BenchSection {
    std::raise(SIGKILL);
    return {};
  };
  const test::TempFolder folder;
  testing::internal::CaptureStderr();
  EXPECT_EQ(run({section_of("first", "| 1 |\n"), refused, crashed, section_of("last", "| 4 |\n")}, folder),
            1);
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              AllOf(HasSubstr("recede_bench: refused: a model is missing\n"),
                    HasSubstr("recede_bench: crashed: crashed (Killed)\n")));
  EXPECT_THAT(
      content_of(folder / "report.md"),
      AllOf(HasSubstr("| 1 |"), HasSubstr("What refused compares.\n\n**Failed:** a model is missing\n"),
            HasSubstr("What crashed compares.\n\n**Failed:** crashed (Killed)\n"), HasSubstr("| 4 |")));
}

TEST(BenchCommand, TheReportHasWhatIsDoneBeforeTheNextSectionBegins) {
  ReportSection second = section_of("second", "");
  second.measure = [](const BenchOptions& options) {
    const std::string so_far = content_of(options.out / "report.md");
    return BenchSection{.markdown = so_far.find("| 1 |") == std::string::npos ? "nothing\n" : "the first\n"};
  };
  const test::TempFolder folder;
  EXPECT_EQ(run({section_of("first", "| 1 |\n"), second}, folder), 0);
  EXPECT_THAT(content_of(folder / "report.md"), HasSubstr("the first\n"));
}

TEST(BenchCommand, OnlyNamedSectionsRunAndSomeOnlyWhenNamed) {
  std::vector<ReportSection> sections{section_of("a", "| a |\n"), section_of("b", "| b |\n"),
                                      section_of("c", "| c |\n")};
  sections[2].when_named = true;
  const test::TempFolder folder;
  EXPECT_EQ(run(sections, folder), 0);
  EXPECT_THAT(content_of(folder / "report.md"),
              AllOf(HasSubstr("| a |"), HasSubstr("| b |"), Not(HasSubstr("| c |"))));
  EXPECT_EQ(run(sections, folder, {"--only", "c,a"}), 0);
  const std::string report = content_of(folder / "report.md");
  EXPECT_THAT(report, AllOf(HasSubstr("| a |"), Not(HasSubstr("| b |")), HasSubstr("| c |")));
  EXPECT_LT(report.find("| a |"), report.find("| c |"));
}

TEST(BenchCommand, ANameThatNoSectionHasIsRefusedWithThoseThereAre) {
  const test::TempFolder folder;
  testing::internal::CaptureStderr();
  EXPECT_EQ(run({section_of("a", ""), section_of("b", "")}, folder, {"--only", "a,d"}), 1);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "recede_bench: no section `d`; there are a, b\n");
  EXPECT_FALSE(std::filesystem::exists(folder / "report.md"));
}

TEST(BenchCommand, QuickMeasuresOnceUnlessRepeatsAreGiven) {
  ReportSection section = section_of("a", "");
  section.measure = [](const BenchOptions& options) {
    return BenchSection{.markdown = "repeats: " + std::to_string(options.repeats) + '\n'};
  };
  const test::TempFolder folder;
  for (const auto& [arguments, repeats] :
       {std::pair(std::vector<const char*>{}, 3), std::pair(std::vector<const char*>{"--quick"}, 1),
        std::pair(std::vector<const char*>{"--quick", "--repeats", "2"}, 2)}) {
    EXPECT_EQ(run({section}, folder, arguments), 0);
    EXPECT_THAT(content_of(folder / "report.md"), HasSubstr("repeats: " + std::to_string(repeats) + '\n'));
  }
}

}  // namespace
}  // namespace recede::bench
