#include "bench_run.h"

#include "models.h"

#include <fmt/format.h>
#include <malloc.h>

#include <regex>

namespace recede::bench {
namespace {

const Goal k_tenth{.name = "10 % of the faces", .face_share = 0.1};
const Goal k_hundredth{.name = "1 % of the faces", .face_share = 0.01};
const Goal k_end{.name = "to its end"};
/// What the plots show.
constexpr const char* k_drawn_model = "bunny00";
constexpr double k_drawn_shares[]{0.5, 0.2, 0.1, 0.05, 0.02, 0.01};
const Goal k_quarter{.name = "25 % of the vertices", .vertex_share = 0.25};

std::vector<Goal> goals_for(const System& system, bool polygons) {
  if (polygons) return system.takes_polygons ? std::vector{k_quarter} : std::vector<Goal>{};
  if (!system.takes_triangles) return {};
  if (system.runs_to_its_end) return {k_tenth, k_hundredth, k_end};
  return {k_tenth, k_hundredth};
}

Model prepare(const ModelSource& source) {
  Model model{source.name, source.polygons, load_model(source), {}};
  model.defects = count_defects(model.soup);
  // What the heap keeps would serve a child's first allocations and lower its peak.
  ::malloc_trim(0);
  return model;
}

void print_row(const Row& row) {
  const std::string place = fmt::format("{}, {}, {}", row.model, row.goal, row.system);
  if (!row.figures) return fmt::print(stderr, "{}: {}\n", place, row.remark);
  const Figures& f = *row.figures;
  const std::string errors = f.with_errors ? fmt::format(", max {:.3g}, RMS {:.3g}", f.max, f.rms) : "";
  fmt::print(stderr, "{}: {} faces in {:.3g} s ({:.3g} s CPU){}{}{}\n", place, f.faces, f.seconds,
             f.cpu_seconds, errors, row.remark.empty() ? "" : "; ", row.remark);
}

std::vector<ModelSource> wanted(std::vector<ModelSource> sources, const BenchOptions& options) {
  std::erase_if(sources, [&](const ModelSource& source) { return !is_wanted(source.name, options.models); });
  return sources;
}

}  // namespace

bool is_wanted(const std::string& name, const std::string& expression) {
  return expression.empty() || std::regex_search(name, std::regex(expression));
}

std::vector<System> wanted_systems(const BenchOptions& options) {
  std::vector<System> systems = all_systems();
  std::erase_if(systems, [&](const System& system) { return !is_wanted(system.name, options.systems); });
  return systems;
}

std::vector<Row> run_simplification(const BenchOptions& options, const AfterModel& after_model) {
  const std::vector<System> systems = wanted_systems(options);
  const std::vector<ModelSource> sources = wanted(all_models(options.data, options.quick), options);
  // Better now than after the first half hour.
  for (const ModelSource& source : sources) require_file(source);
  std::vector<Row> rows;
  for (const ModelSource& source : sources) {
    const Model model = prepare(source);
    for (const System& system : systems) {
      for (const Goal& goal : goals_for(system, model.polygons)) {
        rows.push_back(measure(system, model, goal, {options.repeats, true}));
        print_row(rows.back());
      }
    }
    after_model(rows);
  }
  return rows;
}

std::vector<Row> run_sizes(const BenchOptions& options, const AfterModel& after_model) {
  std::vector<System> systems = wanted_systems(options);
  std::erase_if(systems, [](const System& system) {
    return !system.takes_triangles || system.all_threads || system.runs_to_its_end;
  });
  std::vector<ModelSource> sources = wanted(all_models(options.data, true), options);
  std::erase_if(sources, [](const ModelSource& source) { return source.name != k_drawn_model; });
  std::vector<Row> rows;
  for (const ModelSource& source : sources) {
    require_file(source);
    const Model model = prepare(source);
    for (const double share : k_drawn_shares) {
      const Goal goal{.name = fmt::format("{:g} % of the faces", 100 * share), .face_share = share};
      for (const System& system : systems) {
        rows.push_back(measure(system, model, goal, {options.repeats, true}));
        print_row(rows.back());
      }
    }
    after_model(rows);
  }
  return rows;
}

std::vector<Row> run_growth(const BenchOptions& options, const AfterModel& after_model) {
  std::vector<System> systems = wanted_systems(options);
  std::erase_if(systems, [](const System& system) { return !system.in_growth; });
  std::vector<Row> rows;
  for (const ModelSource& source : wanted(growing_models(options.quick), options)) {
    const Model model = prepare(source);
    for (const System& system : systems) {
      rows.push_back(measure(system, model, k_tenth, {options.repeats, false}));
      print_row(rows.back());
    }
    after_model(rows);
  }
  return rows;
}

}  // namespace recede::bench
