#include "bench_command.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace recede::bench {
namespace {

std::string names_of(const std::vector<ReportSection>& sections, bool when_named) {
  std::string names;
  for (const ReportSection& section : sections) {
    if (section.when_named == when_named) names += (names.empty() ? "" : ", ") + section.name;
  }
  return names;
}

}  // namespace

int run_bench_command(const std::vector<ReportSection>& sections, int argc, const char* const* argv) {
  BenchOptions options;
  std::vector<std::string> names;
  CLI::App app("Measures speed, memory and error, ours beside the peers', into one report.", "recede_bench");
  app.add_option("--data", options.data, "folder with the models (build/data/meshes; `./dev data` fills it)");
  app.add_option("--out", options.out, "folder for report.md, its curves and all numbers (out/bench)");
  app.add_option("--only", names,
                 fmt::format("these sections, NAME[,NAME], instead of {}; only when named: {}",
                             names_of(sections, false), names_of(sections, true)))
      ->delimiter(',');
  app.add_flag("--quick", options.quick, "small inputs, each measured once");
  const CLI::Option* repeats =
      app.add_option("--repeats", options.repeats,
                     "runs whose median counts (3, with --quick 1); long ones get fewer")
          ->check(CLI::PositiveNumber);
  app.add_option("--filter", options.systems,
                 "only systems, or parts of billboards, shells and stability, whose name this regular "
                 "expression finds");
  app.add_option("--models", options.models, "only models or hard cases whose name this expression finds");
  CLI11_PARSE(app, argc, argv);
  if (options.quick && repeats->count() == 0) options.repeats = 1;
  try {
    const std::size_t failures = write_bench_report(choose_sections(sections, names), options);
    fmt::print("{}\n", (options.out / "report.md").string());
    return failures == 0 ? 0 : 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "recede_bench: {}\n", error.what());
    return 1;
  }
}

}  // namespace recede::bench
