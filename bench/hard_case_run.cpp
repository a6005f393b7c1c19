#include "hard_case_run.h"

#include "child_process.h"
#include "hard_cases.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/geometry/polygon_mesh.h>

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>

namespace recede::bench {
namespace {

constexpr double k_share = 0.1;
constexpr unsigned k_judge_seconds = 300;

using test::HardCase;

bool is_finite(const PolygonSoup& soup) {
  return std::all_of(soup.positions.begin(), soup.positions.end(),
                     [](const Vec3& p) { return p.allFinite(); });
}

bool has_same_faces(const PolygonSoup& a, const PolygonSoup& b) {
  if (a.face_offsets != b.face_offsets) return false;
  for (std::size_t c = 0; c < a.n_corners(); ++c) {
    if (a.positions[a.corner_vertices[c]] != b.positions[b.corner_vertices[c]]) return false;
  }
  return true;
}

/// In the child: whether it ran, then what it gave or why it didn't.
std::string run_here(const System& system, const PolygonSoup& soup, const SimplifyTarget& target) {
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, std::size_t{1});
  std::string bytes;
  try {
    const Outcome outcome = system.run(soup, target);
    put(bytes, true);
    put(bytes, outcome.seconds);
    put(bytes, outcome.reported_error);
    put(bytes, outcome.refused_faces);
    put(bytes, outcome.remark);
    put(bytes, outcome.result);
  } catch (const Error& error) {
    bytes.clear();
    put(bytes, false);
    put(bytes, std::string(error.what()));
  }
  return bytes;
}

/// In the child: errors as shares of the diagonal, and defects.
std::string judge_here(const PolygonSoup& input, const PolygonSoup& result) {
  const MeshDistance distance = measure_distance(input, result);
  const double unit = distance.diagonal > 0 ? distance.diagonal : 1;
  std::string bytes;
  put(bytes, distance.max / unit);
  put(bytes, distance.rms / unit);
  put(bytes, unit);
  put(bytes, new_defects(count_defects(result), count_defects(input)));
  return bytes;
}

void judge(const PolygonSoup& input, const PolygonSoup& result, HardCaseRow& row) {
  const ChildAnswer answer = run_in_child([&] { return judge_here(input, result); }, k_judge_seconds);
  if (!answer.succeeded) {
    row.remarks.push_back("not measured: " + answer.failure);
    return;
  }
  ByteReader reader(answer.bytes);
  row.measured = true;
  row.max = reader.take<double>();
  row.rms = reader.take<double>();
  row.reported /= reader.take<double>();
  row.new_defects = reader.take<SurfaceDefects>();
  if (row.reported > 0 && row.max > row.reported + k_exact) {
    row.remarks.push_back(fmt::format("says its error is {:.3g}e-3", 1e3 * row.reported));
  }
}

void remark_on(const PolygonSoup& input, const PolygonSoup& result, std::size_t target, HardCaseRow& row) {
  if (result.n_faces() == 0 && input.n_faces() > 0) {
    row.remarks.push_back("empty mesh");
  } else if (row.faces > target && has_same_faces(input, result)) {
    row.remarks.push_back("input returned unchanged");
  } else if (row.faces > target && row.remarks.empty()) {
    row.remarks.push_back("stops above the target without a word");
  }
  if (!is_finite(result)) row.remarks.push_back("NaN or infinity in the output");
}

HardCaseRow run_system(const System& system, const PolygonSoup& input, std::size_t faces) {
  HardCaseRow row{.system = system.name};
  SimplifyTarget target;
  target.faces = faces;
  const ChildAnswer answer =
      run_in_child([&] { return run_here(system, input, target); }, k_hard_case_seconds);
  if (!answer.succeeded) {
    row.remarks.push_back(answer.failure);
    return row;
  }
  ByteReader reader(answer.bytes);
  row.answered = reader.take<bool>();
  if (!row.answered) {
    row.remarks.push_back("refused: " + reader.take_text());
    return row;
  }
  row.seconds = reader.take<double>();
  row.reported = reader.take<double>();
  row.dropped_faces = reader.take<std::size_t>();
  const std::string said = reader.take_text();
  const PolygonSoup result = reader.take_soup();
  row.faces = result.n_faces();
  if (!said.empty()) row.remarks.push_back(said);
  remark_on(input, result, faces, row);
  if (row.dropped_faces > 0) {
    row.remarks.push_back(fmt::format("{} faces dropped as not manifold", row.dropped_faces));
  }
  if (result.n_faces() > 0 && is_finite(input) && is_finite(result)) judge(input, result, row);
  return row;
}

/// As the command does it: what a file holds is repaired before it is simplified.
Outcome repair_and_simplify(const PolygonSoup& soup, const SimplifyTarget& target) {
  Outcome outcome;
  const WorkTimer setup;
  const PolygonMesh mesh = repair_to_polygon_mesh(soup).mesh;
  outcome.setup_seconds = setup.wall();
  SimplifyOptions options;
  options.target = target;
  SimplifyResult simplified = simplify(mesh, options);
  outcome.seconds = simplified.seconds;
  outcome.proof_seconds = simplified.proof_seconds;
  outcome.reported_error = simplified.error_bound.value_or(0);
  outcome.remark = why_it_stopped_early(simplified);
  outcome.result = to_soup(simplified.mesh);
  return outcome;
}

HardCaseResult run_case(const HardCase& hard_case, const std::vector<System>& systems) {
  const PolygonSoup input = triangulated(hard_case.soup);
  HardCaseResult result{
      .name = hard_case.name, .description = hard_case.description, .faces = input.n_faces()};
  result.target =
      std::max<std::size_t>(1, static_cast<std::size_t>(k_share * static_cast<double>(result.faces)));
  for (const System& system : systems) {
    const HardCaseRow& row = result.systems.emplace_back(run_system(system, input, result.target));
    fmt::print(stderr, "{}, {}: {} faces, max {:.3g}; {}\n", result.name, row.system, row.faces, row.max,
               fmt::join(row.remarks, "; "));
  }
  result.operations = run_operations(hard_case);
  return result;
}

}  // namespace

std::vector<HardCaseResult> run_hard_cases(const BenchOptions& options) {
  std::vector<System> systems = wanted_systems(options);
  std::erase_if(systems, [](const System& system) { return !system.takes_triangles || system.all_threads; });
  if (const System ours{.name = "Recede, repaired first", .run = repair_and_simplify};
      is_wanted(ours.name, options.systems)) {
    systems.insert(systems.begin(), ours);
  }
  std::vector<HardCaseResult> results;
  for (const auto& cases :
       {test::hard_cases(), options.quick ? std::vector<HardCase>{} : test::large_hard_cases()}) {
    for (const HardCase& hard_case : cases) {
      if (is_wanted(hard_case.name, options.models)) results.push_back(run_case(hard_case, systems));
    }
  }
  return results;
}

}  // namespace recede::bench
