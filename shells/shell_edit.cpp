#include <recede/geometry/error.h>
#include <recede/shells/detail/volume_edit.h>
#include <recede/shells/detail/volume_sampler.h>
#include <recede/shells/shell_edit.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace recede {
namespace detail {

void check_filled_once(const VolumeTexture& texture, const LayerGrid& grid) {
  validate(texture, "shell edit");
  if (texture.size != grid.size()) {
    throw InputError(fmt::format("the texture has {} x {} x {} texels, the grid {} x {} x {}",
                                 texture.size[0], texture.size[1], texture.size[2], grid.size()[0],
                                 grid.size()[1], grid.size()[2]));
  }
  if (texture.is_periodic)
    throw InputError("a texture that repeats is at many places: unwrap it before it is edited");
}

std::size_t count_changed(const BrickGrid<std::uint8_t>& before, const BrickGrid<std::uint8_t>& after) {
  std::size_t changed = 0;
  for (std::size_t brick = 0; brick < before.n_bricks(); ++brick) {
    const std::optional<std::uint8_t> old_value = before.uniform_value(brick);
    if (old_value && old_value == after.uniform_value(brick)) continue;
    for_each_texel(before.box(brick), [&](int i, int j, int k) {
      if (before.at(i, j, k) != after.at(i, j, k)) ++changed;
    });
  }
  return changed;
}

}  // namespace detail

namespace {

using detail::ColorGrid;
using detail::OpacityGrid;

/// Samples a body into a grid: what `combine` compares opacity with, where there is a layer.
class BodySampler {
 public:
  BodySampler(const LayerGrid& grid, const InsideDistance& body, const CombineOptions& options)
      : grid_(grid), body_(body), options_(options) {}

  // Returns the volume of the brick's texels within the body. A body often contains or misses a brick as a
  // whole, for which it is asked once.
  double sample(OpacityGrid::Brick& brick) const {
    // Without a layer nothing changes.
    brick.fill(options_.operation == VolumeOperation::intersect ? 255 : 0);
    std::vector<Vec3>& points = points_here();
    points.clear();
    Box3 box;
    double ramp = 0;
    for_each_in_layer(brick.box(), [&](int i, int j, int k) {
      points.push_back(grid_.point(i, j, k));
      box.extend(points.back());
      ramp = std::max({ramp, ramp_of(i, j), edge_of(i, j)});
    });
    if (points.empty()) return 0;
    const Vec3 middle = box.center();
    const double at_middle = inside_by(middle), around = box.diagonal().norm() / 2;
    // Opacity is 0 or 1 from a ramp's length on, a texel's share of the body from half of its side on.
    const bool is_alike = std::abs(at_middle) - around > ramp;
    double volume = 0;
    std::size_t next = 0;
    for_each_in_layer(brick.box(), [&](int i, int j, int k) {
      const Vec3& point = points[next++];
      const double inside = is_alike ? at_middle : inside_by(point);
      // Of the share of a texel that is in the body, as if its surface were flat.
      volume += detail::ramped_opacity(inside, edge_of(i, j)) * grid_.texel_volume(i, j, k);
      brick.at(i, j, k) = detail::opacity_byte(detail::ramped_opacity(inside, ramp_of(i, j)));
    });
    return volume;
  }

 private:
  // Of one thread.
  static std::vector<Vec3>& points_here() {
    thread_local std::vector<Vec3> points;
    return points;
  }

  template <typename Visit>
  void for_each_in_layer(const TexelBox& box, Visit&& visit) const {
    for_each_texel(box, [&](int i, int j, int k) {
      if (grid_.column(i, j).triangle != k_no_index) visit(i, j, k);
    });
  }

  double ramp_of(int i, int j) const { return options_.ramp_texels * grid_.texel_side(i, j); }
  double edge_of(int i, int j) const { return grid_.texel_side(i, j) / 2; }

  double inside_by(const Vec3& point) const {
    const double inside = body_(point);
    if (std::isnan(inside)) {
      throw InputError(fmt::format("the body's distance isn't a number at ({:.6g}, {:.6g}, {:.6g})",
                                   point.x(), point.y(), point.z()));
    }
    return inside;
  }

  const LayerGrid& grid_;
  const InsideDistance& body_;
  const CombineOptions& options_;
};

std::uint8_t combined(VolumeOperation operation, std::uint8_t opacity, std::uint8_t body) {
  switch (operation) {
    case VolumeOperation::unite:
      return std::max(opacity, body);
    case VolumeOperation::intersect:
      return std::min(opacity, body);
    case VolumeOperation::carve:
      break;
  }
  return std::min(opacity, static_cast<std::uint8_t>(255 - body));
}

// `other` is the colour of matter without colours so far.
ColorGrid united_colors(const VolumeTexture& texture, const OpacityGrid& body,
                        const std::array<std::uint8_t, 3>& color, const std::array<std::uint8_t, 3>& other) {
  return ColorGrid::make(texture.size, [&](ColorGrid::Brick& brick) {
    if (texture.colors.empty())
      brick.fill(other);
    else
      brick.copy(texture.colors);
    for_each_texel(brick.box(), [&](int i, int j, int k) {
      if (body.at(i, j, k) > texture.opacity.at(i, j, k)) brick.at(i, j, k) = color;
    });
  });
}

}  // namespace

VolumeTexture make_uniform_volume(const LayerGrid& grid, double opacity) {
  if (!(opacity >= 0 && opacity <= 1)) throw OptionError("opacity is from 0 to 1");
  return {.size = grid.size(),
          .opacity = OpacityGrid(grid.size(), detail::opacity_byte(opacity)),
          .is_periodic = false,
          .extent = grid.mean_extent()};
}

VolumeTexture unwrap_volume(const TexturedShell& textured, const LayerGrid& grid) {
  if (&textured.layer() != &grid.layer())
    throw InputError("the texture to unwrap is in another layer than the grid's");
  VolumeTexture result = make_uniform_volume(grid, 0);
  const VolumeTexture& source = textured.texture->surfaces.front();
  result.ramp = source.ramp * result.extent.z() / source.extent.z();
  const std::vector<Vec2>& uvs = grid.shell().base.corner_uvs;
  // What `sample` says of places in the source.
  const auto sampled = [&](auto& brick, auto&& sample) {
    brick.fill({});
    const TexelBox& box = brick.box();
    for_each_texel({box.first, {box.last[0], box.last[1], box.first[2] + 1}}, [&](int i, int j, int) {
      const LayerGrid::Column& column = grid.column(i, j);
      if (column.triangle == k_no_index) return;
      Vec2 uv = Vec2::Zero();
      for (std::size_t k = 0; k < 3; ++k)
        uv += column.weights[static_cast<int>(k)] * uvs[3 * column.triangle + k];
      const Vec2 st = textured.coordinates.of(uv);
      for (int k = box.first[2]; k < box.last[2]; ++k)
        brick.at(i, j, k) = sample(source, Vec3(st.x(), st.y(), (k + 0.5) / grid.size()[2]));
    });
  };
  result.opacity = OpacityGrid::make(
      grid.size(), [&](OpacityGrid::Brick& brick) { sampled(brick, detail::opacity_byte_at); });
  if (!source.colors.empty()) {
    result.colors = ColorGrid::make(grid.size(),
                                    [&](ColorGrid::Brick& brick) { sampled(brick, detail::color_bytes_at); });
  }
  return result;
}

std::array<int, 3> unwrapped_size(const TexturedShell& textured) {
  textured.layer();
  const VolumeTexture& source = textured.texture->surfaces.front();
  constexpr double k_most = 2048;
  const auto along = [&](std::size_t axis) {
    const double texels = std::abs(textured.coordinates.repeat[static_cast<int>(axis)]) * source.size[axis];
    return static_cast<int>(std::clamp(std::round(texels), 1.0, k_most));
  };
  return {along(0), along(1), source.size[2]};
}

FilledLayer fill_once(const TexturedShell& textured, const std::optional<std::array<int, 3>>& size) {
  textured.layer();
  const VolumeTexture& texture = textured.texture->surfaces.front();
  const bool is_filled_once = !texture.is_periodic && textured.coordinates.repeat == Vec2(1, 1) &&
                              textured.coordinates.offset == Vec2(0, 0) &&
                              size.value_or(texture.size) == texture.size;
  if (is_filled_once) return {LayerGrid(textured.shell, textured.side, texture.size), texture};
  LayerGrid grid(textured.shell, textured.side, size ? *size : unwrapped_size(textured));
  VolumeTexture unwrapped = unwrap_volume(textured, grid);
  return {std::move(grid), std::move(unwrapped)};
}

TexturedShell with_texture(const TexturedShell& textured, VolumeTexture texture) {
  return {.shell = textured.shell, .side = textured.side, .texture = finest_only(std::move(texture))};
}

InsideDistance ball_body(const Vec3& center, double radius) {
  if (!center.allFinite() || !(radius > 0) || !std::isfinite(radius))
    throw OptionError("a ball has finite numbers and a radius above 0");
  return [=](const Vec3& point) { return radius - (point - center).norm(); };
}

InsideDistance mesh_body(std::shared_ptr<const SignedDistance> mesh) {
  return [mesh = std::move(mesh)](const Vec3& point) { return mesh->inside_by(point); };
}

ShellPlace nearest_place(const Shell& shell, const Vec3& point) {
  const PolygonSoup& base = shell.base;
  std::vector<Index> numbers, vertices;  // of triangles with an area, in which places have weights
  for (Index t = 0; t < base.n_faces(); ++t) {
    if (!(vector_area(base, t).norm() > 0)) continue;
    numbers.push_back(t);
    vertices.insert(vertices.end(), base.face(t).begin(), base.face(t).end());
  }
  if (numbers.empty()) throw InputError("a shell without area has no nearest place");
  const ClosestPointTree tree(base.positions, vertices);
  const ClosestPointTree::Hit hit = tree.closest(point);
  if (hit.triangle == k_no_index)
    throw OptionError("no place of a shell is near to a point without a finite distance");
  const Triangle corners = tree.triangle(hit.triangle);
  const Vec3 first = corners.b - corners.a, second = corners.c - corners.a, off = hit.point - corners.a;
  const Vec3 normal = first.cross(second);
  ShellPlace place{.triangle = numbers[hit.triangle]};
  place.weights.y() = off.cross(second).dot(normal) / normal.squaredNorm();
  place.weights.z() = first.cross(off).dot(normal) / normal.squaredNorm();
  place.weights.x() = 1 - place.weights.y() - place.weights.z();
  return place;
}

EditReport combine(VolumeTexture& texture, const LayerGrid& grid, const InsideDistance& body,
                   const CombineOptions& options, Progress* progress) {
  detail::check_filled_once(texture, grid);
  if (!(options.ramp_texels > 0) || !std::isfinite(options.ramp_texels))
    throw OptionError("the ramp at a body's surface must be finite and above 0");
  for (const Vec3& color : {options.color.value_or(Vec3::Zero()), options.other_color}) {
    if (!(color.minCoeff() >= 0 && color.maxCoeff() <= 1)) throw OptionError("colours are from 0 to 1");
  }
  const BodySampler sampler(grid, body, options);
  std::vector<double> volumes(texture.opacity.n_bricks());
  const OpacityGrid sampled = OpacityGrid::make(
      grid.size(),
      [&](OpacityGrid::Brick& brick) { volumes[texture.opacity.number_of(brick)] = sampler.sample(brick); },
      progress, "shell edit");
  OpacityGrid opacity = OpacityGrid::make(grid.size(), [&](OpacityGrid::Brick& brick) {
    for_each_texel(brick.box(), [&](int i, int j, int k) {
      brick.at(i, j, k) = combined(options.operation, texture.opacity.at(i, j, k), sampled.at(i, j, k));
    });
  });
  if (options.color && options.operation == VolumeOperation::unite) {
    texture.colors = united_colors(texture, sampled, detail::color_bytes(*options.color),
                                   detail::color_bytes(options.other_color));
  }
  EditReport report{.changed = detail::count_changed(texture.opacity, opacity)};
  texture.opacity = std::move(opacity);
  if (texture.ramp == 0) {
    texture.ramp =
        options.ramp_texels *
        texture.extent.cwiseQuotient(Vec3(texture.size[0], texture.size[1], texture.size[2])).maxCoeff();
  }
  for (const double volume : volumes) report.volume += volume;
  return report;
}

EditReport cut(VolumeTexture& texture, const LayerGrid& grid,
               const std::function<bool(const Vec3& place, const Vec3& point)>& is_cut) {
  detail::check_filled_once(texture, grid);
  const OpacityGrid& before = texture.opacity;
  std::vector<EditReport> reports(before.n_bricks());
  texture.opacity = OpacityGrid::make(grid.size(), [&](OpacityGrid::Brick& brick) {
    brick.copy(before);
    EditReport& report = reports[before.number_of(brick)];
    for_each_texel(brick.box(), [&](int i, int j, int k) {
      std::uint8_t& opacity = brick.at(i, j, k);
      if (opacity == 0 || grid.column(i, j).triangle == k_no_index) return;
      if (!is_cut(texture.middle(i, j, k), grid.point(i, j, k))) return;
      ++report.changed;
      report.volume += opacity / 255.0 * grid.texel_volume(i, j, k);
      opacity = 0;
    });
  });
  EditReport sum;
  for (const EditReport& report : reports) {
    sum.changed += report.changed;
    sum.volume += report.volume;
  }
  return sum;
}

}  // namespace recede
