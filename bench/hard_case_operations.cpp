// What our own operations do with the hard cases: polygons stay polygons.
#include "child_process.h"
#include "file_round_trip.h"
#include "hard_case_run.h"
#include "hard_cases.h"
#include "scratch_folder.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/lod/lod_hierarchy.h>

#include <fmt/format.h>

namespace recede::bench {
namespace {

using test::HardCase;
namespace fs = std::filesystem;

std::string share_text(double length, double diagonal) {
  const double share = diagonal > 0 ? length / diagonal : length;
  return share < k_exact ? "0" : fmt::format("{:.2g}", share);
}

std::string describe_repair(const PolygonSoup& soup) {
  std::vector<std::string> changes;
  for (const RepairStep& step : repair_to_polygon_mesh(soup).report.steps) {
    if (step.changed > 0) changes.push_back(fmt::format("{} {}", step.name, step.changed));
  }
  return changes.empty() ? "nothing" : fmt::format("{}", fmt::join(changes, ", "));
}

std::string describe_simplify(const PolygonSoup& soup, CostPolicy cost) {
  SimplifyOptions options;
  options.target.ratio = 0.1;
  options.cost = cost;
  const SimplifyResult result = simplify(repair_to_polygon_mesh(soup).mesh, options);
  std::string text = fmt::format("{} of {} faces", result.faces_after, result.faces_before);
  if (!result.error_bound) return text;
  return text + ", bound " + share_text(*result.error_bound, bounding_box(soup).diagonal().norm());
}

std::string describe_distance(const PolygonSoup& soup) {
  const MeshDistance distance = measure_distance(soup, soup, {.samples = 20'000});
  return share_text(distance.max, distance.diagonal);
}

std::string describe_hierarchy(const PolygonSoup& soup, const fs::path& folder) {
  HierarchyOptions options;
  options.ratios = {0.5, 0.1};
  options.measure.samples = 10'000;
  const PolygonMesh mesh = repair_to_polygon_mesh(soup).mesh;
  const HierarchyFiles files = write_hierarchy(folder, build_hierarchy(mesh, "case", options));
  std::vector<std::size_t> faces;
  for (const LodLevel& level : read_hierarchy(files.folder).levels) faces.push_back(level.mesh.n_faces());
  return fmt::format("{} faces", fmt::join(faces, ", "));
}

std::string describe_round_trip(const PolygonSoup& soup, const fs::path& file) {
  return comes_back_from(file, soup) ? "same" : "not the same";
}

/// `work`'s answer or how it ended, without the folder's name.
std::string outcome_of(const std::function<std::string()>& work, const ScratchFolder& folder) {
  const ChildAnswer answer = run_in_child(
      [&]() -> std::string {
        try {
          return work();
        } catch (const Error& error) {
          return fmt::format("refused: {}", error.what());
        }
      },
      k_hard_case_seconds);
  return folder.without_folder(answer.succeeded ? answer.bytes : answer.failure);
}

}  // namespace

std::vector<OperationRow> run_operations(const HardCase& hard_case) {
  const PolygonSoup& soup = hard_case.soup;
  const ScratchFolder folder;
  std::vector<OperationRow> rows;
  const auto add = [&](const char* operation, const std::function<std::string()>& work) {
    rows.push_back({operation, outcome_of(work, folder)});
  };
  add("repair changes", [&] { return describe_repair(soup); });
  add("simplify, `volume`", [&] { return describe_simplify(soup, CostPolicy::volume); });
  add("simplify, `normal_deviation`", [&] { return describe_simplify(soup, CostPolicy::normal_deviation); });
  add("distance to itself", [&] { return describe_distance(soup); });
  add("hierarchy, written and read", [&] { return describe_hierarchy(soup, folder.path()); });
  add("PLY, written and read", [&] { return describe_round_trip(soup, folder.path() / "case.ply"); });
  add("OBJ, written and read", [&] { return describe_round_trip(soup, folder.path() / "case.obj"); });
  return rows;
}

}  // namespace recede::bench
