#include <recede/geometry/detail/nearest_points.h>
#include <recede/geometry/error.h>
#include <recede/shells/detail/hexahedra.h>
#include <recede/shells/detail/shell_building.h>
#include <recede/shells/detail/shell_directors.h>
#include <recede/shells/detail/shell_normals.h>
#include <recede/shells/detail/shell_repair.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace recede {

namespace {

void check(const ShellOptions& options, std::size_t n_vertices, double diagonal) {
  if (options.thicknesses.empty()) {
    if (!(options.thickness > 0)) throw OptionError("a shell's thickness is above 0");
  } else if (options.thicknesses.size() != n_vertices) {
    throw OptionError(
        fmt::format("there are {} thicknesses for {} vertices", options.thicknesses.size(), n_vertices));
  }
  for (const double thickness : options.thicknesses) {
    if (!(thickness > 0)) throw OptionError("a shell's thickness is above 0 at each vertex");
  }
  const double most = options.thicknesses.empty()
                          ? options.thickness
                          : *std::max_element(options.thicknesses.begin(), options.thicknesses.end());
  if (!(most <= diagonal))
    throw OptionError(
        fmt::format("a shell's thickness ({:.6g}) is at most the diagonal of the surface's box ({:.6g})",
                    most, diagonal));
  if (!(options.step > 0 && options.step <= 1))
    throw OptionError("steps of directors are above 0 and at most 1");
  if (!(options.border_extension >= 0 && std::isfinite(options.border_extension)))
    throw OptionError("a border's extension is 0 or more");
}

std::vector<Index> all_vertices(std::size_t n) {
  std::vector<Index> vertices(n);
  std::iota(vertices.begin(), vertices.end(), Index{0});
  return vertices;
}

void find_layers_that_meet(Shell& shell, Progress* progress) {
  shell.layers_meet.clear();
  if (!shell.exterior || !shell.interior) return;
  ShellValidity across =
      check_shell(shell.interior->tops, shell.exterior->tops, shell.base.corner_vertices, {}, progress);
  shell.layers_meet = std::move(across.layer_contacts);
}

// As the field sees a surface: with what goes on past its open borders.
PolygonSoup seen_by_field(const PolygonSoup& base, std::span<const double> thicknesses,
                          const ShellOptions& options) {
  std::vector<double> reaches;
  for (const double thickness : thicknesses) reaches.push_back(options.border_extension * thickness);
  return detail::with_extended_borders(detail::shell_surface_of(base.positions, base.corner_vertices),
                                       reaches);
}

// Of the first `n_vertices`, those within reach of faces with a changed vertex, where they were and where
// they are. Later vertices, beyond borders, have changed where they are elsewhere.
std::vector<Index> vertices_near_changes(const PolygonSoup& before, const PolygonSoup& after,
                                         std::size_t n_vertices, std::span<const Index> changed, double reach,
                                         double small_triangle) {
  std::vector<unsigned char> has_changed(after.positions.size(), 0);
  for (const Index v : changed) {
    if (v >= n_vertices) throw InputError(fmt::format("vertex {} isn't one of the shell's", v));
    has_changed[v] = 1;
  }
  if (std::count(has_changed.begin(), has_changed.end(), 1) == static_cast<std::ptrdiff_t>(n_vertices))
    return all_vertices(n_vertices);
  for (std::size_t v = n_vertices; v < has_changed.size(); ++v)
    has_changed[v] = before.positions[v] != after.positions[v];
  std::vector<Vec3> places;
  double longest = 0;
  for (std::size_t t = 0; t < after.n_faces(); ++t) {
    const std::span<const Index> corners = after.face(t);
    if (std::none_of(corners.begin(), corners.end(), [&](Index v) { return has_changed[v] != 0; })) continue;
    for (const PolygonSoup* soup : {&before, &after}) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 &at = soup->positions[corners[k]], &next = soup->positions[corners[(k + 1) % 3]];
        places.push_back(at);
        longest = std::max(longest, (next - at).norm());
      }
    }
  }
  std::vector<Index> near;
  if (places.empty()) return near;
  // From a corner to any point of its triangle, and what the field sees large ones nearer by: their radius is
  // at most two thirds of their longest side.
  const double beyond = longest + std::max(0.0, 2.0 / 3 * longest - small_triangle);
  const detail::NearestPoints nearest(std::move(places));
  for (Index v = 0; v < n_vertices; ++v) {
    if (nearest.distance(after.positions[v]) <= reach + beyond) near.push_back(v);
  }
  return near;
}

// Shares of the thicknesses, as far as those differ.
void interpolate_directors(const Shell& shell, const LevelInterpolation& between, ShellLayer& layer) {
  const std::vector<Vec3>& positions = shell.base.positions;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (between.is_coarse(v)) continue;
    Vec3 director = Vec3::Zero();
    for (std::size_t i = between.starts[v]; i < between.starts[v + 1]; ++i) {
      const Index other = between.points[i];
      director += between.weights[i] * shell.thicknesses[v] / shell.thicknesses[other] *
                  (layer.traced[other] - positions[other]);
    }
    layer.traced[v] = positions[v] + director;
  }
}

// The first of the two triangles of each quad.
std::vector<Index> quads_of(const PolygonSoup& surface) {
  std::vector<Index> quads;
  Index triangle = 0;
  for (std::size_t f = 0; f < surface.n_faces(); ++f) {
    const auto corners = static_cast<Index>(surface.face(f).size());
    if (corners == 4) quads.push_back(triangle);
    triangle += corners - 2;
  }
  return quads;
}

template <typename Visit>
void each_layer(Shell& shell, ShellSide side, Visit&& visit) {
  if (side != ShellSide::interior) {
    if (!shell.exterior) shell.exterior.emplace();
    visit(*shell.exterior, 1.0);
  }
  if (side != ShellSide::exterior) {
    if (!shell.interior) shell.interior.emplace();
    visit(*shell.interior, -1.0);
  }
}

}  // namespace

bool Shell::is_valid() const {
  return (!exterior || exterior->validity.is_valid()) && (!interior || interior->validity.is_valid()) &&
         layers_meet.empty();
}

namespace detail {

PolygonSoup shell_base_of(const PolygonSoup& surface) {
  validate(surface, "shell");
  if (surface.n_faces() == 0) throw InputError("a shell needs a surface with faces");
  std::vector<Index> faces, corners;
  PolygonSoup base;
  base.positions = surface.positions;
  base.corner_vertices = triangulate(surface, &faces, &corners);
  base.face_offsets.clear();
  for (std::size_t t = 0; t <= faces.size(); ++t) base.face_offsets.push_back(static_cast<Index>(3 * t));
  if (!surface.corner_uvs.empty()) {
    for (const Index corner : corners) base.corner_uvs.push_back(surface.corner_uvs[corner]);
  }
  if (!surface.face_materials.empty()) {
    for (const Index face : faces) base.face_materials.push_back(surface.face_materials[face]);
  }
  base.vertex_colors = surface.vertex_colors;
  base.vertex_scalars = surface.vertex_scalars;
  base.materials = surface.materials;
  return base;
}

Shell shell_without_layers(const PolygonSoup& surface, const ShellOptions& options) {
  Shell shell;
  shell.base = shell_base_of(surface);
  shell.quads = quads_of(surface);
  const std::size_t n = shell.base.positions.size();
  check(options, n, bounding_box(shell.base).diagonal().norm());
  shell.thicknesses =
      options.thicknesses.empty() ? std::vector<double>(n, options.thickness) : options.thicknesses;
  return shell;
}

std::vector<Index> move_shell_base(Shell& shell, PolygonSoup base, std::span<const Index> changed,
                                   const ShellOptions& options) {
  if (base.corner_vertices != shell.base.corner_vertices ||
      base.positions.size() != shell.base.positions.size())
    throw InputError("a shell's surface keeps its triangles when it is deformed");
  check(options, base.positions.size(), bounding_box(base).diagonal().norm());
  if ((options.side != ShellSide::interior) != shell.exterior.has_value() ||
      (options.side != ShellSide::exterior) != shell.interior.has_value())
    throw OptionError("a shell is updated on the sides that it has");
  const double thickest = *std::max_element(shell.thicknesses.begin(), shell.thicknesses.end());
  const double reach = (options.field.form == LpForm::calibrated ? 3.5 : 4) * thickest;
  std::vector<Index> vertices = vertices_near_changes(seen_by_field(shell.base, shell.thicknesses, options),
                                                      seen_by_field(base, shell.thicknesses, options),
                                                      base.positions.size(), changed, reach, thickest / 4);
  shell.base = std::move(base);
  return vertices;
}

void build_layers(Shell& shell, std::span<const Index> vertices, const LevelInterpolation* between,
                  const ShellOptions& options, Progress* progress) {
  const ShellSurface seen = shell_surface_of(shell.base.positions, shell.base.corner_vertices);
  each_layer(shell, options.side, [&](ShellLayer& layer, double side) {
    const TracedDirectors traced =
        trace_directors(seen, vertices, shell.thicknesses, side, options, progress);
    layer.traced.resize(shell.base.positions.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) layer.traced[vertices[i]] = traced.ends[i];
    if (between != nullptr) interpolate_directors(shell, *between, layer);
    layer.evaluations = traced.evaluations;
    repair_layer(seen, side, options.repair, layer, progress);
    layer.is_of_normals = options.repair && options.at_least_normals &&
                          options.method != DirectorMethod::normals &&
                          stand_on_normals(seen, shell.thicknesses, side, layer, progress);
    layer.hexahedra = find_hexahedra(shell, layer, side < 0, progress);
  });
  find_layers_that_meet(shell, progress);
}

}  // namespace detail

Shell build_shell(const PolygonSoup& surface, const ShellOptions& options, Progress* progress) {
  Shell shell = detail::shell_without_layers(surface, options);
  detail::build_layers(shell, all_vertices(shell.base.positions.size()), nullptr, options, progress);
  return shell;
}

std::size_t update_shell(Shell& shell, const PolygonSoup& surface, std::span<const Index> changed_vertices,
                         const ShellOptions& options, Progress* progress) {
  Shell updated = shell;  // a base without its layers would hide from the next update what has changed
  const std::vector<Index> vertices =
      detail::move_shell_base(updated, detail::shell_base_of(surface), changed_vertices, options);
  detail::build_layers(updated, vertices, nullptr, options, progress);
  shell = std::move(updated);
  return vertices.size();
}

}  // namespace recede
