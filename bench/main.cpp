// recede_bench: simplification measured, ours beside the peers, on the same inputs in one run.
#include "appearance_run.h"
#include "bench_report.h"
#include "billboard_run.h"
#ifdef RECEDE_BENCH_CAD
#include "cad_run.h"
#endif
#include "dicing_run.h"
#include "displaced_run.h"
#include "hard_case_run.h"
#include "progressive_run.h"
#include "round_trips.h"
#include "same_bytes.h"
#include "shell_run.h"
#include "stability_run.h"
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
  bool hard_cases = false, same_bytes = false, progressive = false, round_trips = false, displaced = false,
       dicing = false, appearance = false, billboards = false, shells = false, stability = false,
       pictures = false;
  [[maybe_unused]] bool cad = false;
  app.add_flag("--hard-cases", hard_cases,
               "instead, what every system gives on meshes that break simplifiers");
  app.add_flag("--same-bytes", same_bytes, "instead, fingerprints of our results for one and two threads");
  app.add_flag("--progressive", progressive,
               "instead, progressive meshes beside OpenMesh's, textures, charts and maps");
  app.add_flag("--displaced", displaced,
               "instead, rays against displaced surfaces beside Embree's triangles, grids and subdivision");
  app.add_flag("--round-trips", round_trips,
               "instead, progressive meshes of every model in the folder, into files and back");
  app.add_flag("--dicing", dicing, "instead, displaced surfaces diced for views");
  app.add_flag("--appearance", appearance, "instead, reliefs from afar beside rays that meet them");
#ifdef RECEDE_BENCH_CAD
  app.add_flag("--cad", cad, "instead, triangles of CAD models beside those of OpenCASCADE's BRepMesh");
#endif
  app.add_flag("--billboards", billboards,
               "instead, billboard clouds beside those of a Hough transform: texels, outlines, light, cost");
  app.add_flag("--shells", shells,
               "instead, layers of space over real and spoilt models, and the field that they grow along");
  app.add_flag("--stability", stability,
               "instead, every operation over all hard cases and models, and over changed shapes");
  app.add_flag("--pictures", pictures, "pictures of --cad or --billboards instead of their tables");
  app.add_option("--repeats", options.repeats, "runs whose median counts (3); long ones get fewer")
      ->check(CLI::PositiveNumber);
  app.add_option("--filter", options.systems,
                 "only systems, or sections of --billboards, --shells and --stability, whose name this "
                 "regular expression finds");
  app.add_option("--models", options.models, "only models or hard cases whose name this expression finds");
  CLI11_PARSE(app, argc, argv);
  try {
    if (pictures && !cad && !billboards)
      throw recede::OptionError("--pictures goes with --cad or --billboards");
    if (hard_cases) {
      recede::bench::write_hard_cases(recede::bench::run_hard_cases(options), options.out);
      return 0;
    }
    if (progressive) {
      fmt::print("{}", recede::bench::progressive_tables(recede::bench::run_progressive(options)));
      return 0;
    }
    if (displaced) {
      fmt::print("{}", recede::bench::displaced_tables(options));
      return 0;
    }
    if (dicing) {
      fmt::print("{}", recede::bench::dicing_tables(options));
      return 0;
    }
    if (appearance) {
      fmt::print("{}", recede::bench::appearance_tables(options));
      return 0;
    }
    if (billboards) {
      fmt::print("{}", pictures ? recede::bench::billboard_pictures(options)
                                : recede::bench::billboard_tables(options));
      return 0;
    }
    if (stability) {
      fmt::print("{}", recede::bench::stability_tables(options));
      return 0;
    }
    if (shells) {
      fmt::print("{}", recede::bench::shell_tables(options));
      return 0;
    }
#ifdef RECEDE_BENCH_CAD
    if (cad) {
      fmt::print("{}", pictures ? recede::bench::cad_pictures(options) : recede::bench::cad_tables(options));
      return 0;
    }
#endif
    if (same_bytes) {
      fmt::print("{}", recede::bench::same_bytes_table(options.data.parent_path()));
      return 0;
    }
    if (round_trips) {
      fmt::print("{}", recede::bench::round_trips_table(options));
      return 0;
    }
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
