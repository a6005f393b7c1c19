// Directors as they are traced, before any repair.
#include "shell_run.h"
#include "shell_shapes.h"

#include <fmt/format.h>

namespace recede::bench {
namespace {

struct DirectorCase {
  std::string name;
  PolygonSoup surface;
  ShellSide side;
  std::vector<double> thicknesses;
};

std::vector<DirectorCase> director_cases() {
  constexpr ShellSide k_exterior = ShellSide::exterior, k_interior = ShellSide::interior;
  return {{"ball of radius 1, inside", test::ball(16), k_interior, {0.3, 1.5}},
          {"ball, outside", test::ball(16), k_exterior, {0.3}},
          {"cube from -1 to 1, inside", test::cube(8), k_interior, {0.5, 1.5, 3}},
          {"cube, outside", test::cube(8), k_exterior, {0.5}},
          {"saddle z = 0.9 (x^2 - y^2)", test::saddle(), k_exterior, {0.4, 0.8}},
          {"torus of radii 1 and 0.4, outside", test::torus(1, 0.4, 32), k_exterior, {0.35, 0.7}},
          {"waves 0.25 high of period 1", test::corrugated(0.25, 64), k_exterior, {0.1, 0.3, 0.6}},
          {"waves 0.5 high of period 1", test::corrugated(0.5, 64), k_exterior, {0.1, 0.3, 0.6}}};
}

}  // namespace

BenchSection measure_shell_directors(const BenchOptions& options) {
  BenchSection section;
  section.markdown =
      "## Directors before repair\n\nInverted prisms, and pairs that meet; lengths over the thickness are "
      "those along the averaged distance: least, mean, most\n\n| surface | triangles | thickness | normals | "
      "exact distance | averaged | lengths |\n|---|---|---|---|---|---|---|\n";
  for (const DirectorCase& c : director_cases()) {
    if (!is_wanted(c.name, options.models)) continue;
    for (const double thickness : c.thicknesses) {
      section.markdown += fmt::format("| {} | {} | {} |", c.name, c.surface.n_faces(), thickness);
      ShellThickness reached;
      for (const auto& [name, method] :
           {std::pair("normals", DirectorMethod::normals), std::pair("exact", DirectorMethod::exact_distance),
            std::pair("averaged", DirectorMethod::averaged_distance)}) {
        ShellOptions shell_options;
        shell_options.thickness = thickness;
        shell_options.side = c.side;
        shell_options.method = method;
        shell_options.repair = false;
        const Shell shell = build_shell(c.surface, shell_options);
        const ShellLayer& layer = only_layer(shell);
        reached = reached_thickness(shell, layer);
        section.markdown += fmt::format(" {}, {} |", layer.inverted_before, layer.contacts_before);
        section.rows.push_back({{"model", c.name},
                                {"triangles", c.surface.n_faces()},
                                {"thickness", thickness},
                                {"method", name},
                                {"inverted", layer.inverted_before},
                                {"contacts", layer.contacts_before},
                                {"least", reached.least},
                                {"mean", reached.mean},
                                {"most", reached.most}});
      }
      section.markdown +=
          fmt::format(" {:.3f}, {:.3f}, {:.3f} |\n", reached.least, reached.mean, reached.most);
    }
  }
  return section;
}

}  // namespace recede::bench
