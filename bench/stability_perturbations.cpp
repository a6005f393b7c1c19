// The same shapes a little changed: results may change by as much, and not by more.
#include "hard_cases.h"
#include "layer_faults.h"
#include "stability_run.h"
#include <recede/geometry/chart_atlas.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/sample_models.h>
#include <recede/lod/billboard_cloud.h>
#include <recede/lod/simplify.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace recede::bench {
namespace {

struct Perturbed {
  std::string name;
  PolygonSoup soup;
  PolygonSoup exact;  ///< the shape where it is now, without noise
  double noise = 0;   ///< the farthest that a vertex was moved, object units
};

PolygonSoup turned(PolygonSoup soup, double scale, const Vec3& offset) {
  const Eigen::AngleAxisd turn(1, Vec3(1, 2, 3).normalized());
  for (Vec3& p : soup.positions) p = scale * (turn * p) + offset;
  return soup;
}

PolygonSoup noisy(PolygonSoup soup, double amplitude, unsigned seed) {
  std::mt19937 random(seed);
  const auto share = [&] {
    return 2 * static_cast<double>(random()) / static_cast<double>(std::mt19937::max()) - 1;
  };
  for (Vec3& p : soup.positions) p += amplitude / std::numbers::sqrt3 * Vec3(share(), share(), share());
  return soup;
}

std::vector<Perturbed> perturbed(const PolygonSoup& shape) {
  const double diagonal = bounding_box(shape).diagonal().norm();
  std::vector<Perturbed> all{{"as it is", shape, shape}};
  for (const unsigned seed : {1u, 2u})
    all.push_back({fmt::format("other order, seed {}", seed), test::shuffled(shape, seed), shape});
  const auto add_moved = [&](const char* name, double scale, double away) {
    PolygonSoup moved = turned(shape, scale, Vec3::Constant(away * diagonal));
    all.push_back({name, moved, moved});
  };
  add_moved("turned", 1, 0);
  add_moved("a million diagonals away", 1, 1e6);
  add_moved("1e-9 as large", 1e-9, 0);
  add_moved("1e9 as large", 1e9, 0);
  for (const int exponent : {-12, -9, -6, -4, -3, -2, -1}) {
    const double amplitude = std::pow(10.0, exponent) * diagonal;
    all.push_back({fmt::format("vertices moved by 1e{} diagonals", exponent), noisy(shape, amplitude, 1),
                   shape, amplitude});
  }
  return all;
}

/// Lengths are shares of the diagonal.
struct Results {
  std::size_t faces = 0, charts = 0, billboards = 0;
  double error = 0, bound = 0;  ///< of the simplified mesh from the shape without noise; proved
  double layer = 0;             ///< mean length of directors over the thickness
  bool is_of_normals = false;   ///< plain ones took the place of directors
  bool is_layer_valid = false;
  bool is_bound_kept = false;  ///< but for the noise
};

Results results_of(const Perturbed& shape) {
  Results results;
  const PolygonSoup mesh = to_soup(repair_to_polygon_mesh(shape.soup).mesh);
  const double diagonal = bounding_box(shape.exact).diagonal().norm();
  SimplifyOptions options;
  options.target.ratio = 0.1;
  const SimplifySoupResult simplified = simplify(mesh, options);
  results.faces = simplified.faces_after;
  const double bound = simplified.error_bound.value_or(0),
               error = measure_distance(shape.exact, simplified.soup, {.samples = 50'000}).max;
  results.error = error / diagonal;
  results.bound = bound / diagonal;
  constexpr double k_rounding = 1e-9;
  results.is_bound_kept = error <= bound + shape.noise + k_rounding * diagonal;
  results.charts = make_charts(mesh).report.charts;
  BillboardOptions billboards;
  billboards.errors = {0.02 * diagonal};
  results.billboards = build_billboard_clouds(triangulated(mesh), billboards).front().billboards.size();
  const Shell shell = build_shell(mesh, {.thickness = 0.03 * diagonal});
  results.layer = reached_thickness(shell, *shell.exterior).mean;
  results.is_of_normals = shell.exterior->is_of_normals;
  results.is_layer_valid = faults_beside_named(shell, *shell.exterior, ShellSide::exterior) == 0;
  return results;
}

}  // namespace

BenchSection measure_perturbations(const BenchOptions& options) {
  BenchSection section;
  section.markdown =
      "## Perturbations\n\nSimplified to a tenth: faces, largest distance from the shape without noise and "
      "proved bound, in thousandths of the diagonal; number of charts; of billboards 2 % of the diagonal "
      "away; mean length over the thickness of a layer of 3 %. The bound holds but for the noise, and the "
      "layer is valid but over triangles that meet others, unless it is said\n\n| shape | changed | faces | "
      "distance | bound | charts | billboards | layer |\n|---|---|---|---|---|---|---|---|\n";
  std::vector<std::pair<std::string, PolygonSoup>> shapes{
      {"ball with ridges", make_displaced_sphere(5000, true)}};
  for (const char* name : {"elephant.off", "fandisk.off", "mannequin-devil.off", "bunny00.off"}) {
    const std::filesystem::path file = options.data / name;
    if (std::filesystem::exists(file)) shapes.emplace_back(name, read_soup(file));
  }
  for (const auto& [name, soup] : shapes) {
    if (!is_wanted(name, options.models)) continue;
    for (const Perturbed& changed : perturbed(soup)) {
      const Results found = results_of(changed);
      section.markdown +=
          fmt::format("| {} | {} | {} | {:.3g} | {:.3g}{} | {} | {} | {:.3f}{}{} |\n", name, changed.name,
                      found.faces, 1e3 * found.error, 1e3 * found.bound,
                      found.is_bound_kept ? "" : " **not kept**", found.charts, found.billboards, found.layer,
                      found.is_of_normals ? " (normals)" : "", found.is_layer_valid ? "" : " **not valid**");
      section.rows.push_back({{"shape", name},
                              {"changed", changed.name},
                              {"faces", found.faces},
                              {"distance", found.error},
                              {"bound", found.bound},
                              {"is_bound_kept", found.is_bound_kept},
                              {"charts", found.charts},
                              {"billboards", found.billboards},
                              {"layer", found.layer},
                              {"is_of_normals", found.is_of_normals},
                              {"is_layer_valid", found.is_layer_valid}});
      fmt::print(stderr, "{}, {}\n", name, changed.name);
    }
  }
  return section;
}

BenchSection measure_stability(const BenchOptions& options) {
  return run_sections(options, "Stability", "stability",
                      {{"operations", measure_operations}, {"perturbations", measure_perturbations}});
}

}  // namespace recede::bench
