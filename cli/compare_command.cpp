#include "common.h"

#include <fmt/format.h>

#include <chrono>

namespace recede::cli {
namespace {

struct CompareOptions {
  CommonOptions common;
  std::string first, second;
  DistanceOptions distance{.bound_tolerance = 0.05};
  bool no_bound = false;
};

Json side_to_json(const OneSidedDistance& side) {
  return {{"max", side.max},
          {"rms", side.rms},
          {"mean", side.mean},
          {"at", {side.at.x(), side.at.y(), side.at.z()}}};
}

void print_text(const MeshDistance& d, const Model& first, const Model& second) {
  fmt::print("faces        {} and {}\n", first.read.mesh.n_faces(), second.read.mesh.n_faces());
  fmt::print("maximum      {}, sampled\n", length_text(d.max, d.diagonal));
  if (d.max_bound) {
    fmt::print("bound        {}, certified; the maximum is at least {:.4g}\n",
               length_text(*d.max_bound, d.diagonal), d.max_lower);
  }
  fmt::print("rms          {}\n", length_text(d.rms, d.diagonal));
  const auto print_side = [&](const char* name, const OneSidedDistance& side) {
    fmt::print("{}  max {:.4g} at {:.4g} {:.4g} {:.4g}, rms {:.4g}, mean {:.4g}\n", name, side.max,
               side.at.x(), side.at.y(), side.at.z(), side.rms, side.mean);
  };
  print_side("1st to 2nd ", d.forward);
  print_side("2nd to 1st ", d.backward);
  fmt::print("samples      {} points, {:.4g} per unit of area; % are of the first mesh's diagonal, {:.6g}\n",
             d.samples, d.samples_per_unit_area, d.diagonal);
}

void run(CompareOptions options) {
  TerminalProgress progress(options.common.quiet);
  const Model first = read_model(options.first, &progress);
  const Model second = read_model(options.second, &progress);
  require_faces(first, options.first);
  require_faces(second, options.second);
  if (options.no_bound) options.distance.bound_tolerance.reset();
  const auto start = std::chrono::steady_clock::now();
  const MeshDistance d = measure_distance(first.read.mesh, second.read.mesh, options.distance, &progress);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  progress.clear();
  print_repairs(first.read.report, options.common);
  print_repairs(second.read.report, options.common);
  if (!options.common.json) return print_text(d, first, second);
  print_json({{"command", "compare"},
              {"first", {{"input", options.first}, {"faces", first.read.mesh.n_faces()}}},
              {"second", {{"input", options.second}, {"faces", second.read.mesh.n_faces()}}},
              {"error", error_to_json(d.max, d.rms, d.max_bound, d.diagonal)},
              {"max_lower", d.max_lower},
              {"forward", side_to_json(d.forward)},
              {"backward", side_to_json(d.backward)},
              {"diagonal", d.diagonal},
              {"samples", d.samples},
              {"samples_per_unit_area", d.samples_per_unit_area},
              {"seconds", seconds}});
}

}  // namespace

void add_compare_command(CLI::App& app) {
  const auto options = std::make_shared<CompareOptions>();
  CLI::App* command = app.add_subcommand("compare", "Measures the distance between two surfaces, both ways.");
  command->footer("Example:\n  recede compare dragon.ply dragon_small.ply --bound-tolerance 0.01");
  command->add_option("first", options->first, k_input_help)->required();
  command->add_option("second", options->second, "the other mesh")->required();
  command->add_option("--samples", options->distance.samples, "sample points per surface (200000)")
      ->check(above_zero());
  command
      ->add_option("--bound-tolerance", *options->distance.bound_tolerance,
                   "width of the certified interval as a share of the bound (0.05)")
      ->check(between(1e-6, 0.999999));
  command->add_flag("--no-bound", options->no_bound, "sample only; certify nothing");
  add_common_options(*command, options->common);
  command->callback([options] { run(*options); });
}

}  // namespace recede::cli
