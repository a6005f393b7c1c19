// Layers over real models.
#include "shell_run.h"
#include "surface_defects.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/polygon_mesh.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace recede::bench {
namespace {

constexpr std::size_t k_most_triangles = 100'000;
constexpr std::array<double, 3> k_shares{0.02, 0.05, 0.1};  // of the longest side

// Repaired as the command does, and nothing if it has borders beside those that repair makes.
std::optional<PolygonSoup> closed_surface(const std::filesystem::path& file) {
  PolygonSoup surface = to_soup(repair_to_polygon_mesh(read_soup(file)).mesh);
  if (surface.n_faces() == 0 || count_defects(surface).border_edges > 0) return {};
  return surface;
}

// A share of the longest side; 0 where none was found. Valid ones are assumed to be so for all below.
double valid_share_of_normals(const PolygonSoup& surface, double size, ShellSide side) {
  const auto is_valid = [&](double share) {
    ShellOptions options;
    options.thickness = share * size;
    options.side = side;
    options.method = DirectorMethod::normals;
    options.repair = false;
    return only_layer(build_shell(surface, options)).is_valid_elsewhere;
  };
  if (is_valid(k_shares.back())) return k_shares.back();
  constexpr int k_steps = 9;  // to 1.8 %
  double valid = k_shares.back() / 10'000, not_valid = k_shares.back();
  if (!is_valid(valid)) return 0;
  for (int step = 0; step < k_steps; ++step) {
    const double middle = std::sqrt(valid * not_valid);
    (is_valid(middle) ? valid : not_valid) = middle;
  }
  return valid;
}

struct MeasuredLayer {
  ShellThickness reached;
  std::string verdict;
  /// As thick on average, but for a hundredth, as all normals may be.
  bool is_thick_enough = true;
  nlohmann::json row;
};

MeasuredLayer measure(const PolygonSoup& surface, double size, ShellSide side, double share, double normals) {
  const auto [shell, seconds] = build_timed(surface, side, share * size);
  const ShellLayer& layer = only_layer(shell);
  const ShellThickness reached = reached_thickness(shell, layer);
  constexpr double k_about = 0.99;
  MeasuredLayer measured{
      reached, verdict_of(layer), reached.mean * share >= k_about * std::min(normals, share), {}};
  measured.row = {{"side", name_of(side)},
                  {"thickness_share", share},
                  {"is_valid", layer.validity.is_valid()},
                  {"is_valid_elsewhere", layer.is_valid_elsewhere},
                  {"excused", layer.excused.size()},
                  {"given_up", layer.given_up.size()},
                  {"inverted", layer.validity.inverted.size()},
                  {"base_contacts", layer.validity.bottom_contacts.size()},
                  {"rounds", layer.repair_rounds},
                  {"mean", reached.mean},
                  {"least", reached.least},
                  {"normals_valid_share", normals},
                  {"is_as_thick_as_normals", measured.is_thick_enough},
                  {"seconds", seconds}};
  return measured;
}

void add_side(const std::string& name, const PolygonSoup& surface, ShellSide side, BenchSection& section) {
  const double size = bounding_box(surface).sizes().maxCoeff();
  const double normals = valid_share_of_normals(surface, size, side);
  std::string cells, verdicts;
  for (const double share : k_shares) {
    MeasuredLayer measured = measure(surface, size, side, share, normals);
    cells += fmt::format(" {:.3f}{} ; {:.2g} |", measured.reached.mean, measured.is_thick_enough ? "" : "*",
                         measured.reached.least);
    if (verdicts.find(measured.verdict) == std::string::npos)
      verdicts += (verdicts.empty() ? "" : " ; ") + measured.verdict;
    measured.row["model"] = name;
    measured.row["triangles"] = triangulated(surface).n_faces();
    section.rows.push_back(std::move(measured.row));
  }
  const bool is_exterior = side == ShellSide::exterior;
  section.markdown +=
      fmt::format("| {} | {} | {:.3g} |{} {} |\n",
                  is_exterior ? fmt::format("{}, {}", name, triangulated(surface).n_faces()) : "",
                  name_of(side), 100 * normals, cells, verdicts);
}

}  // namespace

BenchSection measure_shell_models(const BenchOptions& options) {
  BenchSection section;
  section.markdown =
      "## Models\n\nThicknesses are shares of the longest side. Of each layer: mean and least length of "
      "directors over the thickness; * where the mean is more than 1 % below what all normals may have "
      "(third "
      "column; up to 10)\n\n| model, triangles | side | normals valid up to, % | 2 % | 5 % | 10 % | valid |\n"
      "|---|---|---|---|---|---|---|\n";
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(options.data)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const std::filesystem::path& file : files) {
    const std::string name = file.stem().string();
    if (!is_wanted(name, options.models)) continue;
    try {
      const std::optional<PolygonSoup> surface = closed_surface(file);
      if (!surface || triangulated(*surface).n_faces() > k_most_triangles) continue;
      for (const ShellSide side : {ShellSide::exterior, ShellSide::interior})
        add_side(name, *surface, side, section);
      fmt::print(stderr, "{} has its layers\n", name);
    } catch (const Error& error) {
      fmt::print(stderr, "{}: {}\n", file.string(), error.what());
      section.markdown += fmt::format("| {} | | | | | | refused: {} |\n", name, error.what());
    }
  }
  return section;
}

}  // namespace recede::bench
