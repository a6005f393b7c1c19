// Layers over one mesh spoilt in many ways.
#include "shell_run.h"
#include "torture_set.h"
#include <recede/geometry/error.h>
#include <recede/geometry/polygon_mesh.h>

#include <fmt/format.h>

namespace recede::bench {
namespace {

constexpr std::size_t k_triangles = 5856;
constexpr double k_share = 0.03;  // of the longest side

void add_layer(const test::TortureVariant& variant, ShellSide side, BenchSection& section) {
  nlohmann::json row = {{"model", variant.name}, {"side", name_of(side)}};
  try {
    const PolygonSoup surface = to_soup(repair_to_polygon_mesh(variant.soup).mesh);
    const auto [shell, seconds] =
        build_timed(surface, side, k_share * bounding_box(surface).sizes().maxCoeff());
    const ShellLayer& layer = only_layer(shell);
    const ShellThickness reached = reached_thickness(shell, layer);
    section.markdown += fmt::format(" {} | {:.3f} | {:.2g} |", verdict_of(layer), reached.mean, seconds);
    row["triangles"] = shell.base.n_faces();
    row["is_valid"] = layer.validity.is_valid();
    row["is_valid_elsewhere"] = layer.is_valid_elsewhere;
    row["excused"] = layer.excused.size();
    row["given_up"] = layer.given_up.size();
    row["mean"] = reached.mean;
    row["least"] = reached.least;
    row["seconds"] = seconds;
  } catch (const Error& error) {
    section.markdown += fmt::format(" refused: {} | | |", error.what());
    row["refusal"] = error.what();
  }
  section.rows.push_back(std::move(row));
}

}  // namespace

BenchSection measure_shell_torture(const BenchOptions& options) {
  BenchSection section;
  section.markdown = fmt::format(
      "## Spoilt meshes\n\nA ball of {} triangles and fifteen variants, repaired as the command does; "
      "thickness {} % of the longest side. Valid, or but over how many triangles; mean length; seconds\n\n"
      "| variant | | exterior | mean | s | interior | mean | s |\n|---|---|---|---|---|---|---|---|\n",
      k_triangles, 100 * k_share);
  for (const test::TortureVariant& variant : test::torture_set(k_triangles)) {
    if (!is_wanted(variant.name, options.models)) continue;
    section.markdown += fmt::format("| {} | {} |", variant.name, variant.description);
    for (const ShellSide side : {ShellSide::exterior, ShellSide::interior}) add_layer(variant, side, section);
    section.markdown += '\n';
  }
  return section;
}

}  // namespace recede::bench
