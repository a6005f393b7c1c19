// Operations with checks of what they promise, over all shapes.
#include "child_process.h"
#include "cloud_check.h"
#include "file_round_trip.h"
#include "hard_cases.h"
#include "layer_faults.h"
#include "same_bits.h"
#include "scratch_folder.h"
#include "shell_run.h"
#include "stability_run.h"
#include "torture_set.h"
#include <recede/geometry/chart_atlas.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/geometry/mesh_io.h>
#include <recede/lod/lod_hierarchy.h>
#include <recede/lod/pmesh.h>

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>

namespace recede::bench {
namespace {

namespace fs = std::filesystem;

constexpr unsigned k_seconds_allowed = 300;
/// Rounding, as a share of the diagonal.
constexpr double k_rounding = 1e-9;

/// An operation broke a promise.
struct Broken : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Operation {
  const char* name;
  /// Throws `Broken` when a check fails, `Error` when the shape is refused. The folder is for files.
  void (*run)(const PolygonSoup& soup, const fs::path& folder);
};

void check_repair(const PolygonSoup& soup, const fs::path&) {
  const PolygonSoup repaired = to_soup(repair_to_polygon_mesh(soup).mesh);
  validate(repaired, "the repaired mesh");
  const PolygonSoup again = to_soup(repair_to_polygon_mesh(repaired).mesh);
  if (again.positions != repaired.positions || again.face_offsets != repaired.face_offsets ||
      again.corner_vertices != repaired.corner_vertices)
    throw Broken("repairing what was repaired changes it");
}

void check_simplified(const PolygonSoup& soup, CostPolicy cost) {
  SimplifyOptions options;
  options.target.ratio = 0.1;
  options.cost = cost;
  const PolygonMesh mesh = repair_to_polygon_mesh(soup).mesh;
  const SimplifyResult result = simplify(mesh, options);
  const PolygonSoup simplified = to_soup(result.mesh);
  validate(simplified, "the simplified mesh");
  if (result.faces_after != simplified.n_faces()) throw Broken("the number of faces is another");
  if (!result.error_bound) return;
  const MeshDistance found = measure_distance(to_soup(mesh), simplified, {.samples = 20'000});
  if (found.max > *result.error_bound + k_rounding * found.diagonal)
    throw Broken(fmt::format("off by {:.3g}, bound {:.3g}", found.max, *result.error_bound));
}

void check_volume(const PolygonSoup& soup, const fs::path&) { check_simplified(soup, CostPolicy::volume); }

void check_normal_deviation(const PolygonSoup& soup, const fs::path&) {
  check_simplified(soup, CostPolicy::normal_deviation);
}

void check_progressive(const PolygonSoup& soup, const fs::path& folder) {
  ProgressiveOptions options;
  options.simplify.target.ratio = 0.01;
  options.simplify.prove_error = false;
  const fs::path file = folder / "case.pmesh";
  write_pmesh(file, build_progressive_mesh(soup, options), {.keep_numbering = true});
  const ProgressiveMesh back = read_pmesh(file);
  ProgressiveCursor cursor(back);
  cursor.move_to(back.n_splits());
  const std::string difference = test::first_difference(cursor.soup(), soup);
  if (!difference.empty()) throw Broken("not restored: " + difference);
}

void check_atlas(const PolygonSoup& soup, const fs::path&) {
  const PolygonSoup mesh = to_soup(repair_to_polygon_mesh(soup).mesh);
  const AtlasResult atlas = make_atlas(mesh);
  if (atlas.flipped > 0) throw Broken(fmt::format("{} triangles are flipped", atlas.flipped));
  for (const Vec2& uv : atlas.soup.corner_uvs) {
    if (!(uv.minCoeff() >= 0 && uv.maxCoeff() <= 1)) throw Broken("a coordinate outside of 0 to 1");
  }
}

void check_layer(const PolygonSoup& soup, ShellSide side) {
  const PolygonSoup mesh = to_soup(repair_to_polygon_mesh(soup).mesh);
  ShellOptions options;
  options.thickness = 0.05 * bounding_box(mesh).sizes().maxCoeff();
  options.side = side;
  const Shell shell = build_shell(mesh, options);
  const ShellLayer& layer = only_layer(shell);
  const std::size_t faults = faults_beside_named(shell, layer, side);
  if (!layer.is_valid_elsewhere || faults > 0)
    throw Broken(fmt::format("{} faults beside the triangles that it names", faults));
}

void check_exterior(const PolygonSoup& soup, const fs::path&) { check_layer(soup, ShellSide::exterior); }

void check_interior(const PolygonSoup& soup, const fs::path&) { check_layer(soup, ShellSide::interior); }

void check_billboards(const PolygonSoup& soup, const fs::path&) {
  const PolygonSoup model = triangulated(to_soup(repair_to_polygon_mesh(soup).mesh));
  BillboardOptions options;
  if (model.n_faces() > 0) options.errors = {0.02 * bounding_box(model).sizes().maxCoeff()};
  const BillboardCloud cloud = build_billboard_clouds(model, options).front();
  const CloudCheck check = check_cloud(model, cloud, false);
  if (!check.is_sound(options.largest_deviation))
    throw Broken(fmt::format("{:.3g} errors away, {:.3g} radians turned, {} faces in none, {} in several",
                             check.distance, check.deviation, check.uncovered, check.repeated));
}

void check_hierarchy(const PolygonSoup& soup, const fs::path& folder) {
  HierarchyOptions options;
  options.ratios = {0.5, 0.1};
  options.measure.samples = 10'000;
  const LodHierarchy hierarchy = build_hierarchy(repair_to_polygon_mesh(soup).mesh, "case", options);
  const LodHierarchy back = read_hierarchy(write_hierarchy(folder / "case", hierarchy).folder);
  if (back.levels.size() != hierarchy.levels.size()) throw Broken("another number of levels");
  for (std::size_t i = 0; i < back.levels.size(); ++i) {
    const LevelError& error = hierarchy.levels[i].error;
    if (error.max > error.bound * (1 + k_rounding) + k_rounding * hierarchy.radius)
      throw Broken(fmt::format("level {} is off by {:.3g}, bound {:.3g}", i, error.max, error.bound));
    const std::size_t written = triangulated(to_soup(hierarchy.levels[i].mesh)).n_faces();
    if (triangulated(to_soup(back.levels[i].mesh)).n_faces() != written)
      throw Broken(fmt::format("level {} has other triangles in its file", i));
  }
}

void check_files(const PolygonSoup& soup, const fs::path& folder) {
  for (const char* extension : {"ply", "obj", "off"}) {
    if (!comes_back_from(folder / fmt::format("case.{}", extension), soup))
      throw Broken(fmt::format("{} gives other polygons", extension));
  }
}

void check_distance(const PolygonSoup& soup, const fs::path&) {
  const MeshDistance found = measure_distance(soup, soup, {.samples = 20'000});
  if (found.max > k_rounding * found.diagonal)
    throw Broken(fmt::format("{:.3g} away from itself", found.max));
}

constexpr Operation k_operations[] = {{"repair", check_repair},
                                      {"simplify, `volume`", check_volume},
                                      {"`normal_deviation`", check_normal_deviation},
                                      {"progressive", check_progressive},
                                      {"atlas", check_atlas},
                                      {"shell, exterior", check_exterior},
                                      {"interior", check_interior},
                                      {"billboards", check_billboards},
                                      {"hierarchy", check_hierarchy},
                                      {"PLY, OBJ, OFF", check_files},
                                      {"distance", check_distance}};

enum class Kind : char { done = 'd', refused = 'r', broken = 'b', ended = 'e' };

struct OperationOutcome {
  Kind kind = Kind::done;
  std::string text;  ///< why not, in words
};

using Load = std::function<PolygonSoup()>;

OperationOutcome run_operation(const Operation& operation, const Load& load) {
  const ScratchFolder folder;
  const ChildAnswer answer = run_in_child(
      [&]() -> std::string {
        const auto line = [](Kind kind, const std::string& why) {
          return std::string(1, static_cast<char>(kind)) + why;
        };
        try {
          operation.run(load(), folder.path());
          return line(Kind::done, "");
        } catch (const Broken& broken) {
          return line(Kind::broken, broken.what());
        } catch (const Error& error) {
          return line(Kind::refused, error.what());
        }
      },
      k_seconds_allowed);
  if (!answer.succeeded) return {Kind::ended, answer.failure};
  return {static_cast<Kind>(answer.bytes.front()), folder.without_folder(answer.bytes.substr(1))};
}

struct Shape {
  std::string name;
  Load load;
};

std::vector<Shape> all_shapes(const BenchOptions& options) {
  std::vector<Shape> shapes;
  for (const test::HardCase& hard_case : test::hard_cases())
    shapes.push_back({hard_case.name, [soup = hard_case.soup] { return soup; }});
  for (const test::TortureVariant& variant : test::torture_set(600))
    shapes.push_back({"ball, " + variant.name, [soup = variant.soup] { return soup; }});
  std::vector<fs::path> files;
  for (const fs::path& folder : {options.data, options.data.parent_path() / "cad" / "stl"}) {
    if (!fs::exists(folder)) continue;
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files)
    shapes.push_back({file.filename().string(), [file] { return read_soup(file); }});
  std::erase_if(shapes, [&](const Shape& shape) { return !is_wanted(shape.name, options.models); });
  return shapes;
}

std::string mark_of(const OperationOutcome& outcome) {
  switch (outcome.kind) {
    case Kind::done:
      return "ok";
    case Kind::refused:
      return "refused";
    case Kind::broken:
      return "**broken**";
    case Kind::ended:
      return "**" + outcome.text + "**";
  }
  return "";
}

}  // namespace

BenchSection measure_operations(const BenchOptions& options) {
  BenchSection section;
  section.markdown = fmt::format(
      "## Operations\n\n`ok`: done, and a check of what it promises found nothing; each in a process of its "
      "own, which ends after {} s\n\n| shape |",
      k_seconds_allowed);
  std::string rule = "\n|---|";
  for (const Operation& operation : k_operations) {
    section.markdown += fmt::format(" {} |", operation.name);
    rule += "---|";
  }
  section.markdown += rule + '\n';
  std::map<Kind, std::size_t> counts;
  std::string reasons;
  for (const Shape& shape : all_shapes(options)) {
    section.markdown += fmt::format("| {} |", shape.name);
    std::map<std::string, std::string> operations_of_reason;
    for (const Operation& operation : k_operations) {
      const OperationOutcome outcome = run_operation(operation, shape.load);
      ++counts[outcome.kind];
      section.markdown += fmt::format(" {} |", mark_of(outcome));
      section.rows.push_back({{"shape", shape.name},
                              {"operation", operation.name},
                              {"outcome", mark_of(outcome)},
                              {"reason", outcome.text}});
      if (outcome.kind == Kind::done) continue;
      std::string& names = operations_of_reason[outcome.text];
      names += (names.empty() ? "" : ", ") + std::string(operation.name);
    }
    section.markdown += '\n';
    for (const auto& [reason, names] : operations_of_reason)
      reasons += fmt::format("- {}: {}: {}\n", shape.name, names, reason);
    fmt::print(stderr, "{}\n", shape.name);
  }
  section.markdown +=
      fmt::format("\n{} ok, {} refused, {} broken, {} without an answer\n\n{}", counts[Kind::done],
                  counts[Kind::refused], counts[Kind::broken], counts[Kind::ended], reasons);
  return section;
}

}  // namespace recede::bench
