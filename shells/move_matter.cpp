#include <recede/geometry/error.h>
#include <recede/shells/detail/surface_disc.h>
#include <recede/shells/detail/volume_edit.h>
#include <recede/shells/shell_edit.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

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

using detail::ColorGrid;
using detail::OpacityGrid;

// What a column of texels gets.
struct ColumnMove {
  bool is_emptied = false;
  std::optional<Vec2> source{};  // texture coordinates of what is united with it
};

/// Of all columns of a grid.
class MatterMove {
 public:
  MatterMove(const LayerGrid& grid, const MoveOptions& options, const detail::SurfaceDisc& from,
             const detail::SurfaceDisc& to)
      : size_(grid.size()),
        columns_(static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1])),
        without_source_(static_cast<std::size_t>(size_[1])) {
    const PolygonSoup& base = grid.shell().base;
    if (!options.is_copy) {
      for_each_column(grid, from, options.radius,
                      [&](int i, int j, const Vec2&) { columns_[number(i, j)].is_emptied = true; });
    }
    const Eigen::Rotation2Dd back(-options.turn);
    for_each_column(grid, to, options.radius, [&](int i, int j, const Vec2& point) {
      const std::optional<ShellPlace> place = from.from_plane(back * point);
      if (!place) {
        without_source_[static_cast<std::size_t>(j)] += static_cast<std::size_t>(size_[2]);
        return;
      }
      Vec2 uv = Vec2::Zero();
      for (std::size_t k = 0; k < 3; ++k)
        uv += place->weights[static_cast<int>(k)] * base.corner_uvs[3 * place->triangle + k];
      columns_[number(i, j)].source = uv;
    });
  }

  std::size_t without_source() const {
    return std::accumulate(without_source_.begin(), without_source_.end(), std::size_t{0});
  }

  VolumeTexture applied_to(const VolumeTexture& texture) const {
    VolumeTexture result = texture;
    // The opacity that what moves there is united with.
    const auto left = [&](int i, int j, int k) {
      return columns_[number(i, j)].is_emptied ? std::uint8_t{0} : texture.opacity.at(i, j, k);
    };
    result.opacity = OpacityGrid::make(size_, [&](OpacityGrid::Brick& brick) {
      for_each_texel(brick.box(), [&](int i, int j, int k) {
        const std::optional<Vec2>& source = columns_[number(i, j)].source;
        brick.at(i, j, k) = left(i, j, k);
        if (source)
          brick.at(i, j, k) = std::max(brick.at(i, j, k), detail::opacity_byte_at(texture, at(*source, k)));
      });
    });
    if (texture.colors.empty()) return result;
    result.colors = ColorGrid::make(size_, [&](ColorGrid::Brick& brick) {
      brick.copy(texture.colors);
      for_each_texel(brick.box(), [&](int i, int j, int k) {
        const std::optional<Vec2>& source = columns_[number(i, j)].source;
        if (source && result.opacity.at(i, j, k) > left(i, j, k))
          brick.at(i, j, k) = detail::color_bytes_at(texture, at(*source, k));
      });
    });
    return result;
  }

 private:
  // What `visit` makes of columns within a disc's radius and their points in the plane.
  template <typename Visit>
  static void for_each_column(const LayerGrid& grid, const detail::SurfaceDisc& disc, double radius,
                              Visit&& visit) {
    tbb::parallel_for(0, grid.size()[1], [&](int j) {
      for (int i = 0; i < grid.size()[0]; ++i) {
        const LayerGrid::Column& column = grid.column(i, j);
        if (column.triangle == k_no_index) continue;
        const std::optional<Vec2> point = disc.to_plane(column.triangle, column.weights);
        if (point && point->norm() < radius) visit(i, j, *point);
      }
    });
  }
  std::size_t number(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(size_[0]) + static_cast<std::size_t>(i);
  }
  Vec3 at(const Vec2& source, int k) const { return {source.x(), source.y(), (k + 0.5) / size_[2]}; }

  std::array<int, 3> size_;
  std::vector<ColumnMove> columns_;
  std::vector<std::size_t> without_source_;  // texels, of rows of columns
};

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

  const MatterMove move(grid, options, from, to);
  VolumeTexture moved = move.applied_to(texture);
  report.without_source = move.without_source();
  report.edit.changed = detail::count_changed(texture.opacity, moved.opacity);
  texture = std::move(moved);
  return report;
}

}  // namespace recede
