#include "cad_meshers.h"
#include "cad_run.h"
#include "plot_sheet.h"
#include <recede/geometry/atomic_file.h>
#include <recede/lod/view_settings.h>

#include <fmt/format.h>

#include <array>

namespace recede::bench {
namespace {

/// Pixels that the diagonal covers.
constexpr std::array<double, 11> k_sizes{1000, 600, 300, 170, 100, 60, 30, 17, 10, 6, 3};
constexpr double k_usual_angle = 0.5;  // radians, BRepMesh's default

/// Triangles of all instances, for each level.
std::vector<std::size_t> count(const CadSubject& subject,
                               const std::vector<std::vector<CadBodyMesh>>& levels) {
  std::vector<std::size_t> uses(subject.model.parts.size(), 0), counts;
  for (const CadInstance& instance : subject.model.instances) ++uses[instance.part];
  for (const std::vector<CadBodyMesh>& meshes : levels) {
    std::size_t& n = counts.emplace_back(0);
    for (std::size_t b = 0; b < meshes.size(); ++b) {
      for (const CadFaceMesh& face : meshes[b].faces)
        n += face.triangles.size() * uses[subject.bodies[b].part];
    }
  }
  return counts;
}

struct Curve {
  const char* name;
  std::vector<std::size_t> counts;
};

Plot plot_of(const CadSubject& subject, const std::vector<double>& distances,
             const std::vector<Curve>& curves) {
  std::size_t n_patches = 0;
  for (const CadInstance& instance : subject.model.instances)
    n_patches += subject.model.parts[instance.part].patches.size();
  Plot plot = log_plot(fmt::format("{}: {} patches", subject.name, n_patches),
                       "distance in diagonals, 1080 pixels high, 45 degrees", "triangles");
  for (const Curve& curve : curves) {
    for (std::size_t i = 0; i < distances.size(); ++i)
      add_point(plot, curve.name, distances[i], static_cast<double>(curve.counts[i]));
  }
  return plot;
}

}  // namespace

std::string cad_distance_plots(const BenchOptions& options) {
  const std::filesystem::path folder = options.data.parent_path() / "cad/occ";
  std::string text;
  std::vector<Plot> plots;
  for (const CadSubject& subject :
       {load_cad_assembly(4000), load_cad({"Top.brep", false, folder / "Top.brep"})}) {
    std::vector<double> deflections, distances;
    for (const double size : k_sizes) {
      deflections.push_back(subject.diagonal / size / 2);
      distances.push_back(1 / (size * pixel_footprint(1, {})));
    }
    const std::vector<Curve> curves{
        {"Recede", count(subject, recede_meshes(subject, deflections))},
        {"all seams", count(subject, recede_meshes(subject, deflections, true))},
        {"BRepMesh", count(subject, brep_meshes(subject, deflections, k_usual_angle))},
        {"wide angle", count(subject, brep_meshes(subject, deflections))}};
    text += fmt::format("\n| {}, pixels |", subject.name);
    for (const Curve& curve : curves) text += fmt::format(" {} |", curve.name);
    text += "\n|---|---|---|---|---|\n";
    for (std::size_t i = 0; i < k_sizes.size(); ++i) {
      text += fmt::format("| {:.0f} |", k_sizes[i]);
      for (const Curve& curve : curves) text += fmt::format(" {} |", curve.counts[i]);
      text += '\n';
    }
    plots.push_back(plot_of(subject, distances, curves));
  }
  write_file_atomically(options.out / "cad-distances.svg", plot_sheet(plots));
  return text;
}

}  // namespace recede::bench
