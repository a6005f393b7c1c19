#include <recede/geometry/error.h>
#include <recede/shells/detail/shell_building.h>
#include <recede/shells/subdivided_shell.h>

#include <fmt/format.h>

namespace recede {

namespace {

SubdivisionOptions at_level(SubdivisionOptions options, int level) {
  options.level = level;
  options.error.reset();
  return options;
}

std::vector<Index> coarse_points(const LevelInterpolation& interpolation) {
  std::vector<Index> points;
  for (std::size_t v = 0; v < interpolation.n_points(); ++v) {
    if (interpolation.is_coarse(v)) points.push_back(static_cast<Index>(v));
  }
  return points;
}

}  // namespace

SubdividedShell build_subdivided_shell(const PolygonSoup& control, const SubdividedShellOptions& options,
                                       Progress* progress) {
  const SubdivisionResult surface = subdivide(control, options.subdivision, progress);
  if (options.interpolated_levels < 0 || options.interpolated_levels > surface.level)
    throw OptionError(fmt::format("directors can be interpolated over 0 to {} levels, not {}", surface.level,
                                  options.interpolated_levels));
  SubdividedShell result;
  result.control = control;
  result.level = surface.level;
  result.interpolation = interpolate_level(control, at_level(options.subdivision, surface.level),
                                           surface.level - options.interpolated_levels);
  const std::vector<Index> vertices = coarse_points(result.interpolation);
  result.traced = vertices.size();
  result.shell = detail::shell_without_layers(surface.soup, options.shell);
  detail::build_layers(result.shell, vertices, &result.interpolation, options.shell, progress);
  return result;
}

void update_subdivided_shell(SubdividedShell& shell, const PolygonSoup& control,
                             const SubdividedShellOptions& options, Progress* progress) {
  if (control.corner_vertices != shell.control.corner_vertices ||
      control.face_offsets != shell.control.face_offsets ||
      control.positions.size() != shell.control.positions.size())
    throw InputError("a control mesh keeps its faces when it is deformed");
  SubdivisionResult surface = subdivide(control, at_level(options.subdivision, shell.level), progress);
  const Shell& before = shell.shell;
  const bool is_loop = options.subdivision.scheme == SubdivisionScheme::loop;
  if (surface.soup.positions.size() != before.base.positions.size() ||
      (is_loop && surface.soup.corner_vertices != before.base.corner_vertices))
    throw InputError("a control mesh whose polygons are cut for Loop keeps the triangles");
  // Where faces are cut along their better diagonals, these stay as they were.
  PolygonSoup base = before.base;
  base.positions = std::move(surface.soup.positions);
  std::vector<Index> changed;
  for (Index v = 0; v < base.positions.size(); ++v) {
    if (base.positions[v] != before.base.positions[v]) changed.push_back(v);
  }
  Shell updated = before;
  std::vector<Index> vertices = detail::move_shell_base(updated, std::move(base), changed, options.shell);
  std::erase_if(vertices, [&](Index v) { return !shell.interpolation.is_coarse(v); });
  detail::build_layers(updated, vertices, &shell.interpolation, options.shell, progress);
  shell.shell = std::move(updated);
  shell.control = control;
  shell.traced = vertices.size();
}

}  // namespace recede
