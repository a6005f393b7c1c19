#include <recede/geometry/error.h>
#include <recede/shells/detail/volume_edit.h>
#include <recede/shells/detail/volume_sampler.h>
#include <recede/shells/shell_edit.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
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

std::size_t count_changed(const VolumeTexture& before, const VolumeTexture& after) {
  std::size_t changed = 0;
  for (std::size_t texel = 0; texel < before.opacity.size(); ++texel)
    changed += before.opacity[texel] != after.opacity[texel] ? 1 : 0;
  return changed;
}

void give_colors(VolumeTexture& texture, const Vec3& color) {
  if (texture.colors.empty()) texture.colors.assign(texture.n_texels(), color_bytes(color));
}

}  // namespace detail

namespace {

// Texels are asked for in cubes, which a body often contains or misses as a whole.
constexpr int k_block = 4;

struct Block {
  std::array<int, 3> first, last;  // last is the one behind
};

class Combiner {
 public:
  Combiner(VolumeTexture& texture, const LayerGrid& grid, const InsideDistance& body,
           const CombineOptions& options)
      : texture_(texture), grid_(grid), body_(body), options_(options) {
    for (std::size_t axis = 0; axis < 3; ++axis) blocks_[axis] = (grid.size()[axis] + k_block - 1) / k_block;
  }

  int n_rows() const { return blocks_[1] * blocks_[2]; }

  // Volumes of a row's blocks within the body.
  double combine_row(int row) {
    double volume = 0;
    for (int i = 0; i < blocks_[0]; ++i) {
      const std::array<int, 3> at{i, row % blocks_[1], row / blocks_[1]};
      Block block{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        block.first[axis] = at[axis] * k_block;
        block.last[axis] = std::min(block.first[axis] + k_block, grid_.size()[axis]);
      }
      volume += combine_block(block);
    }
    return volume;
  }

 private:
  double combine_block(const Block& block) {
    points_here().clear();
    Box3 box;
    double ramp = 0;
    for_each_texel(block, [&](int i, int j, int k) {
      points_here().push_back(grid_.point(i, j, k));
      box.extend(points_here().back());
      ramp = std::max(ramp, ramp_of(i, j));
    });
    if (points_here().empty()) return 0;
    const Vec3 middle = box.center();
    const double at_middle = inside_by(middle), around = box.diagonal().norm() / 2;
    // Opacity is 0 or 1 from a ramp's length on.
    const bool is_alike = std::abs(at_middle) - around > ramp;
    double volume = 0;
    std::size_t next = 0;
    for_each_texel(block, [&](int i, int j, int k) {
      const Vec3& point = points_here()[next++];
      const double inside = is_alike ? at_middle : inside_by(point);
      const double opacity = detail::ramped_opacity(inside, ramp_of(i, j));
      // Of the share of a texel that is in the body, as if its surface were flat.
      volume += detail::ramped_opacity(inside, grid_.texel_side(i, j) / 2) * grid_.texel_volume(i, j, k);
      set(texture_.texel(i, j, k), detail::opacity_byte(opacity));
    });
    return volume;
  }

  // Of one thread.
  static std::vector<Vec3>& points_here() {
    thread_local std::vector<Vec3> points;
    return points;
  }

  template <typename Visit>
  void for_each_texel(const Block& block, Visit&& visit) const {
    for (int k = block.first[2]; k < block.last[2]; ++k) {
      for (int j = block.first[1]; j < block.last[1]; ++j) {
        for (int i = block.first[0]; i < block.last[0]; ++i)
          if (grid_.column(i, j).triangle != k_no_index) visit(i, j, k);
      }
    }
  }

  double ramp_of(int i, int j) const { return options_.ramp_texels * grid_.texel_side(i, j); }

  double inside_by(const Vec3& point) const {
    const double inside = body_(point);
    if (std::isnan(inside)) {
      throw InputError(fmt::format("the body's distance isn't a number at ({:.6g}, {:.6g}, {:.6g})",
                                   point.x(), point.y(), point.z()));
    }
    return inside;
  }

  void set(std::size_t texel, std::uint8_t body) {
    std::uint8_t& opacity = texture_.opacity[texel];
    if (options_.operation == VolumeOperation::unite) {
      if (options_.color && body > opacity) texture_.colors[texel] = color_;
      opacity = std::max(opacity, body);
    } else if (options_.operation == VolumeOperation::intersect) {
      opacity = std::min(opacity, body);
    } else {
      opacity = std::min(opacity, static_cast<std::uint8_t>(255 - body));
    }
  }

  VolumeTexture& texture_;
  const LayerGrid& grid_;
  const InsideDistance& body_;
  const CombineOptions& options_;
  std::array<std::uint8_t, 3> color_ = detail::color_bytes(options_.color.value_or(Vec3::Zero()));
  std::array<int, 3> blocks_{};
};

}  // namespace

VolumeTexture make_uniform_volume(const LayerGrid& grid, double opacity) {
  if (!(opacity >= 0 && opacity <= 1)) throw OptionError("opacity is from 0 to 1");
  VolumeTexture texture{.size = grid.size(), .is_periodic = false};
  texture.opacity.assign(texture.n_texels(), detail::opacity_byte(opacity));
  texture.extent = grid.mean_extent();
  return texture;
}

VolumeTexture unwrap_volume(const TexturedShell& textured, const LayerGrid& grid) {
  if (&textured.layer() != &grid.layer())
    throw InputError("the texture to unwrap is in another layer than the grid's");
  VolumeTexture result = make_uniform_volume(grid, 0);
  const VolumeTexture& source = textured.texture->surfaces.front();
  if (!source.colors.empty()) result.colors.resize(result.n_texels());
  result.ramp = source.ramp * result.extent.z() / source.extent.z();
  const std::vector<Vec2>& uvs = grid.shell().base.corner_uvs;
  tbb::parallel_for(0, grid.size()[1], [&](int j) {
    for (int i = 0; i < grid.size()[0]; ++i) {
      const LayerGrid::Column& column = grid.column(i, j);
      if (column.triangle == k_no_index) continue;
      Vec2 uv = Vec2::Zero();
      for (std::size_t k = 0; k < 3; ++k)
        uv += column.weights[static_cast<int>(k)] * uvs[3 * column.triangle + k];
      const Vec2 st = textured.coordinates.of(uv);
      for (int k = 0; k < grid.size()[2]; ++k) {
        const detail::VolumeSample sample =
            detail::sample_at(source, {st.x(), st.y(), (k + 0.5) / grid.size()[2]});
        const std::size_t texel = result.texel(i, j, k);
        result.opacity[texel] = sample.opacity;
        if (!result.colors.empty()) result.colors[texel] = sample.color;
      }
    }
  });
  return result;
}

std::array<int, 3> unwrapped_size(const TexturedShell& textured) {
  textured.layer();
  const VolumeTexture& source = textured.texture->surfaces.front();
  constexpr double k_most = 4096;
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
  const ClosestPointTree tree(shell.base.positions, shell.base.corner_vertices);
  const ClosestPointTree::Hit hit = tree.closest(point);
  const Triangle corners = tree.triangle(hit.triangle);
  const Vec3 first = corners.b - corners.a, second = corners.c - corners.a, off = hit.point - corners.a;
  const Vec3 normal = first.cross(second);
  ShellPlace place{.triangle = hit.triangle};
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
  VolumeTexture edited = texture;
  if (options.color && options.operation == VolumeOperation::unite)
    detail::give_colors(edited, options.other_color);
  Combiner combiner(edited, grid, body, options);
  std::vector<double> volumes(static_cast<std::size_t>(combiner.n_rows()));
  // Some rows at a time, so that it can be cancelled.
  constexpr int k_rows = 64;
  for (int first = 0; first < combiner.n_rows(); first += k_rows) {
    report_progress(progress, "shell edit", static_cast<double>(first) / combiner.n_rows());
    tbb::parallel_for(first, std::min(first + k_rows, combiner.n_rows()),
                      [&](int row) { volumes[static_cast<std::size_t>(row)] = combiner.combine_row(row); });
  }
  report_progress(progress, "shell edit", 1);
  EditReport report{.changed = detail::count_changed(texture, edited)};
  if (edited.ramp == 0) {
    edited.ramp =
        options.ramp_texels *
        edited.extent.cwiseQuotient(Vec3(edited.size[0], edited.size[1], edited.size[2])).maxCoeff();
  }
  for (const double volume : volumes) report.volume += volume;
  texture = std::move(edited);
  return report;
}

EditReport cut(VolumeTexture& texture, const LayerGrid& grid,
               const std::function<bool(const Vec3& place, const Vec3& point)>& is_cut) {
  detail::check_filled_once(texture, grid);
  std::vector<EditReport> rows(static_cast<std::size_t>(grid.size()[1]));
  tbb::parallel_for(0, grid.size()[1], [&](int j) {
    EditReport& row = rows[static_cast<std::size_t>(j)];
    for (int k = 0; k < grid.size()[2]; ++k) {
      for (int i = 0; i < grid.size()[0]; ++i) {
        std::uint8_t& opacity = texture.opacity[texture.texel(i, j, k)];
        if (opacity == 0 || grid.column(i, j).triangle == k_no_index) continue;
        if (!is_cut(texture.middle(i, j, k), grid.point(i, j, k))) continue;
        ++row.changed;
        row.volume += opacity / 255.0 * grid.texel_volume(i, j, k);
        opacity = 0;
      }
    }
  });
  EditReport report;
  for (const EditReport& row : rows) {
    report.changed += row.changed;
    report.volume += row.volume;
  }
  return report;
}

}  // namespace recede
