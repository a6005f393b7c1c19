#include <recede/geometry/error.h>
#include <recede/shells/detail/surface_disc.h>
#include <recede/shells/detail/volume_edit.h>
#include <recede/shells/shell_edit.h>

#include <tbb/parallel_for.h>

#include <cmath>

namespace recede {
namespace {

void check(const MoveOptions& options, const PolygonSoup& base) {
  if (!(options.radius > 0) || !std::isfinite(options.radius))
    throw OptionError("the radius of what moves must be finite and above 0");
  if (!std::isfinite(options.turn)) throw OptionError("the angle by which matter turns must be finite");
  for (const ShellPlace& place : {options.from, options.to}) {
    constexpr double k_rounding = 1e-6;
    if (place.triangle >= base.n_faces() || !(place.weights.minCoeff() >= -k_rounding) ||
        !(std::abs(place.weights.sum() - 1) <= k_rounding))
      throw OptionError("the places from and to which matter moves must be on the shell's base");
    if (!(vector_area(base, place.triangle).norm() > 0))
      throw OptionError("the places from and to which matter moves must be on triangles of some area");
  }
}

Vec3 unit_normal(const PolygonSoup& base, const ShellPlace& place) {
  return vector_area(base, place.triangle).stableNormalized();
}

// Of the grid's columns within a disc's radius: what `visit` makes of a column and its point in the plane.
template <typename Visit>
void for_each_column(const LayerGrid& grid, const detail::SurfaceDisc& disc, double radius, Visit&& visit) {
  tbb::parallel_for(0, grid.size()[1], [&](int j) {
    for (int i = 0; i < grid.size()[0]; ++i) {
      const LayerGrid::Column& column = grid.column(i, j);
      if (column.triangle == k_no_index) continue;
      const std::optional<Vec2> point = disc.to_plane(column.triangle, column.weights);
      if (point && point->norm() < radius) visit(i, j, *point);
    }
  });
}

}  // namespace

MoveReport move_matter(VolumeTexture& texture, const LayerGrid& grid, const MoveOptions& options) {
  detail::check_filled_once(texture, grid);
  const PolygonSoup& base = grid.shell().base;
  check(options, base);
  const Vec3 normal = unit_normal(base, options.from);
  const Vec3 axis = normal.unitOrthogonal();
  const Vec3 turned = Eigen::Quaterniond::FromTwoVectors(normal, unit_normal(base, options.to)) * axis;
  const detail::SurfaceDisc from(base, options.from, options.radius, axis),
      to(base, options.to, options.radius, turned);
  MoveReport report{.stretch = std::max(from.stretch(), to.stretch())};

  const VolumeTexture source = texture;
  if (!options.is_copy) {
    for_each_column(grid, from, options.radius, [&](int i, int j, const Vec2&) {
      for (int k = 0; k < grid.size()[2]; ++k) texture.opacity[texture.texel(i, j, k)] = 0;
    });
  }
  const Eigen::Rotation2Dd back(-options.turn);
  std::vector<std::size_t> without(static_cast<std::size_t>(grid.size()[1]), 0);
  for_each_column(grid, to, options.radius, [&](int i, int j, const Vec2& point) {
    const std::optional<ShellPlace> place = from.from_plane(back * point);
    if (!place) {
      without[static_cast<std::size_t>(j)] += static_cast<std::size_t>(grid.size()[2]);
      return;
    }
    Vec2 uv = Vec2::Zero();
    for (std::size_t k = 0; k < 3; ++k)
      uv += place->weights[static_cast<int>(k)] * base.corner_uvs[3 * place->triangle + k];
    for (int k = 0; k < grid.size()[2]; ++k) {
      const detail::VolumeSample moved =
          detail::sample_at(source, {uv.x(), uv.y(), (k + 0.5) / grid.size()[2]});
      const std::size_t texel = texture.texel(i, j, k);
      if (moved.opacity <= texture.opacity[texel]) continue;
      texture.opacity[texel] = moved.opacity;
      if (!texture.colors.empty()) texture.colors[texel] = moved.color;
    }
  });
  for (const std::size_t texels : without) report.without_source += texels;
  report.edit.changed = detail::count_changed(source, texture);
  return report;
}

}  // namespace recede
