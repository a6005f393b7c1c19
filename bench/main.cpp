// recede_bench: simplification measured, ours beside the peers, on the same inputs in one run.
#include "bench_report.h"
#include <recede/geometry/error.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>

int main(int argc, char** argv) {
  recede::bench::BenchOptions options;
  CLI::App app("Measures simplification: speed, memory and error, ours beside the peers'.", "recede_bench");
  app.add_option("--data", options.data, "folder with the models (build/data/meshes; `./dev data` fills it)");
  app.add_option("--out", options.out, "folder for results.csv, results.md and the plots (out/bench)");
  app.add_flag("--quick", options.quick, "without the largest models");
  app.add_flag("--growth", options.growth, "also time Recede and meshoptimizer over growing sizes");
  app.add_option("--repeats", options.repeats, "runs whose median counts (3); long ones get fewer")
      ->check(CLI::PositiveNumber);
  app.add_option("--filter", options.systems, "only systems whose name this regular expression finds");
  app.add_option("--models", options.models, "only models whose name this regular expression finds");
  CLI11_PARSE(app, argc, argv);
  try {
    const auto results = recede::bench::run_bench(
        options, [&](const auto& so_far) { recede::bench::write_report(so_far, options.out); });
    fmt::print("{}", recede::bench::summary_tables(results));
  } catch (const std::exception& error) {
    std::string line = error.what();
    std::replace(line.begin(), line.end(), '\n', ' ');
    fmt::print(stderr, "recede_bench: {}\n", line);
    return 1;
  }
  return 0;
}
