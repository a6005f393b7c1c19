#include "measurement.h"

#include "child_process.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace recede::bench {
namespace {

/// No repeat begins once a measurement has used this much time; large models get fewer.
constexpr double k_repeat_seconds = 15;
/// All runs of one measurement and the evaluation of its error.
constexpr unsigned k_seconds_allowed = 900;
/// Of the certified interval, as `recede compare` has it.
constexpr double k_bound_tolerance = 0.05;
constexpr double k_target_slack = 1.01;

std::size_t excess(std::size_t after, std::size_t before) { return after > before ? after - before : 0; }

std::size_t share_of(double share, std::size_t count) {
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::floor(share * static_cast<double>(count))));
}

SimplifyTarget target_of(const Goal& goal, const PolygonSoup& soup) {
  SimplifyTarget target;
  if (goal.face_share) target.faces = share_of(*goal.face_share, soup.n_faces());
  if (goal.vertex_share) target.vertices = share_of(*goal.vertex_share, soup.positions.size());
  return target;
}

/// Fills in times and memory; hands back the first run's outcome.
Outcome time_runs(const System& system, const PolygonSoup& soup, const SimplifyTarget& target,
                  std::size_t repeats, Figures& figures) {
  std::unique_ptr<tbb::global_control> limit;
  if (!system.all_threads) {
    limit =
        std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, std::size_t{1});
  }
  const std::size_t resident_before = resident_bytes();
  forget_peak();
  const WorkTimer all;
  Outcome first;
  std::vector<double> setup, seconds, cpu, proof;
  while (seconds.empty() || (seconds.size() < repeats && all.wall() < k_repeat_seconds)) {
    Outcome outcome = system.run(soup, target);
    setup.push_back(outcome.setup_seconds);
    seconds.push_back(outcome.seconds);
    cpu.push_back(outcome.cpu_seconds);
    proof.push_back(outcome.proof_seconds);
    if (seconds.size() == 1) first = std::move(outcome);
  }
  figures.runs = seconds.size();
  figures.setup_seconds = median(setup);
  figures.seconds = median(seconds);
  figures.cpu_seconds = median(cpu);
  figures.proof_seconds = median(proof);
  figures.peak_bytes = excess(first.peak_bytes, resident_before);
  figures.call_peak_bytes = first.call_peak_bytes;
  return first;
}

void judge(const Model& model, const Outcome& outcome, Figures& figures) {
  DistanceOptions options;
  options.bound_tolerance = k_bound_tolerance;
  figures.with_errors = true;
  const MeshDistance distance = measure_distance(model.soup, outcome.result, options);
  figures.max = distance.max / distance.diagonal;
  figures.rms = distance.rms / distance.diagonal;
  figures.bound = distance.max_bound.value_or(0) / distance.diagonal;
  figures.reported = outcome.reported_error / distance.diagonal;
  figures.new_defects = new_defects(count_defects(outcome.result), model.defects);
}

std::string measure_here(const System& system, const Model& model, const SimplifyTarget& target,
                         const MeasureOptions& options) {
  Figures figures;
  const Outcome outcome = time_runs(system, model.soup, target, options.repeats, figures);
  if (outcome.refused_faces > 0) {
    throw Error(fmt::format("refuses {} faces as not manifold", outcome.refused_faces));
  }
  figures.faces = outcome.result.n_faces();
  figures.vertices = outcome.result.positions.size();
  if (figures.faces == 0) throw Error("the result is empty");
  figures.quad_share = quad_share(outcome.result);
  if (options.with_errors) judge(model, outcome, figures);
  return as_bytes(figures) + outcome.remark;
}

}  // namespace

CallMeter::CallMeter() : setup_peak_(peak_resident_bytes()), resident_before_(resident_bytes()) {
  forget_peak();
  timer_ = {};
}

void CallMeter::stop(Outcome& outcome) const {
  outcome.seconds = timer_.wall();
  outcome.cpu_seconds = timer_.cpu();
  const std::size_t call_peak = peak_resident_bytes();
  outcome.call_peak_bytes = excess(call_peak, resident_before_);
  outcome.peak_bytes = std::max(setup_peak_, call_peak);
}

std::vector<System> all_systems() {
  std::vector<System> systems;
  add_our_systems(systems);
  add_meshoptimizer(systems);
#ifdef RECEDE_BENCH_CGAL
  add_cgal(systems);
#endif
#ifdef RECEDE_BENCH_VTK
  add_vtk(systems);
#endif
  add_openmesh(systems);
  return systems;
}

double Row::million_faces_per_second() const {
  return figures ? 1e-6 * static_cast<double>(input_faces) / figures->seconds : 0;
}

bool Row::reached_target() const {
  if (!figures) return false;
  const std::size_t count = goal.ends_with("vertices") ? figures->vertices : figures->faces;
  return target == 0 || static_cast<double>(count) <= k_target_slack * static_cast<double>(target);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

double median_seconds(std::size_t runs, const std::function<void()>& work,
                      const std::function<void()>& before_each) {
  std::vector<double> seconds;
  while (seconds.size() < runs) {
    if (before_each) before_each();
    const WorkTimer timer;
    work();
    seconds.push_back(timer.cpu());
  }
  return median(seconds);
}

double median_wall_seconds(std::size_t runs, const std::function<void()>& work) {
  std::vector<double> seconds;
  while (seconds.size() < runs) {
    const WorkTimer timer;
    work();
    seconds.push_back(timer.wall());
  }
  return median(seconds);
}

Row measure(const System& system, const Model& model, const Goal& goal, const MeasureOptions& options) {
  const SimplifyTarget target = target_of(goal, model.soup);
  Row row{.model = model.name,
          .goal = goal.name,
          .system = system.name,
          .label = system.label,
          .all_threads = system.all_threads,
          .polygons = model.polygons,
          .input_faces = model.soup.n_faces(),
          .input_vertices = model.soup.positions.size(),
          .target = target.faces.value_or(target.vertices.value_or(0))};
  const ChildAnswer answer =
      run_in_child([&] { return measure_here(system, model, target, options); }, k_seconds_allowed);
  row.remark = answer.failure;
  if (answer.succeeded) {
    row.figures = ByteReader(answer.bytes).take<Figures>();
    row.remark = answer.bytes.substr(sizeof(Figures));
  }
  return row;
}

}  // namespace recede::bench
