#include <recede/geometry/detail/hashed_number.h>
#include <recede/render/detail/tracing.h>
#include <recede/render/detail/volume_look.h>
#include <recede/shells/detail/shell_cell.h>
#include <recede/shells/detail/shell_pieces.h>
#include <recede/shells/detail/volume_sampler.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace recede {

VolumeView volume_view(const Camera& camera) { return {camera.position, frame_of(camera).pixel}; }

namespace detail {

using Vec3f = Eigen::Vector3f;
using Matrix3 = Eigen::Matrix3d;

namespace {

// The most that opacity changes from a texel to the next, along each axis.
Vec3 steepest_slopes(const VolumeTexture& texture) {
  using Slopes = std::array<int, 3>;
  const BrickGrid<std::uint8_t>& opacity = texture.opacity;
  const auto in_brick = [&](std::size_t brick, Slopes& most) {
    const TexelBox box = opacity.box(brick);
    const bool is_uniform = opacity.uniform_value(brick).has_value();
    for_each_texel(box, [&](int i, int j, int k) {
      const std::array<int, 3> at{i, j, k};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        std::array<int, 3> next = at;
        if (is_uniform && at[axis] + 1 < box.last[axis]) continue;
        if (++next[axis] == texture.size[axis]) {
          if (axis == 2 || !texture.is_periodic) continue;
          next[axis] = 0;
        }
        most[axis] = std::max(most[axis], std::abs(opacity.at(next) - opacity.at(at)));
      }
    });
  };
  const Slopes most = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, opacity.n_bricks()), Slopes{0, 0, 0},
      [&](const tbb::blocked_range<std::size_t>& bricks, Slopes sum) {
        for (std::size_t brick = bricks.begin(); brick < bricks.end(); ++brick) in_brick(brick, sum);
        return sum;
      },
      [](Slopes a, const Slopes& b) {
        for (std::size_t axis = 0; axis < 3; ++axis) a[axis] = std::max(a[axis], b[axis]);
        return a;
      });
  return Vec3(most[0], most[1], most[2]) / 255;
}

}  // namespace

VolumeLook::VolumeLook(const PlacedVolume& placed, const Vec3& center, double scale)
    : texture_(placed.textured.texture),
      is_inward_(placed.textured.side == ShellSide::interior),
      color_(placed.color),
      view_(placed.view) {
  const ShellLayer& layer = placed.textured.layer();
  const PolygonSoup& base = placed.textured.shell->base;
  for (std::size_t v = 0; v < base.positions.size(); ++v) {
    bottoms_.push_back((base.positions[v] - center) * scale);
    directors_.push_back((layer.tops[v] - base.positions[v]) * scale);
  }
  triangles_ = base.corner_vertices;
  for (const Vec2& uv : base.corner_uvs) places_.push_back(placed.textured.coordinates.of(uv));
  set_cells(*placed.textured.shell, layer);
  for (const VolumeTexture& level : texture_->surfaces) {
    slopes_.push_back(steepest_slopes(level));
    empty_.emplace_back(level);
  }
  if (view_) view_->eye = (view_->eye - center) * scale;
  set_frames();
  set_texels();
}

void VolumeLook::set_cells(const Shell& shell, const ShellLayer& layer) {
  const auto n_triangles = static_cast<std::uint32_t>(triangles_.size() / 3);
  auto quad = layer.hexahedra.begin();
  for (std::uint32_t t = 0; t < n_triangles; ++t) {
    if (quad != layer.hexahedra.end() && *quad == t) {
      cells_.push_back({quad_corners(triangles_, t), 4});
      ++quad;
      ++t;
    } else {
      cells_.push_back({{3 * t, 3 * t + 1, 3 * t + 2, 0}, 3});
    }
  }
  std::vector<std::uint8_t> is_open(triangles_.size(), 0);
  for (const Index corner : find_open_sides(shell.base.positions.size(), triangles_)) is_open[corner] = 1;
  for (const CellCorners& cell : cells_) {
    std::uint8_t borders = 0;
    for (std::uint32_t k = 0; k < cell.n; ++k) {
      // Of a quad's second side the corner is that of the other triangle.
      const std::uint32_t begins =
          cell.n == 4 && k == 1 ? previous_in_triangle(cell.corners[2]) : cell.corners[k];
      borders = static_cast<std::uint8_t>(borders | (is_open[begins] << k));
    }
    borders_.push_back(borders);
  }
}

void VolumeLook::Frame::add(float weight, const Frame& other) {
  bottom_s += weight * other.bottom_s;
  bottom_t += weight * other.bottom_t;
  top_s += weight * other.top_s;
  top_t += weight * other.top_t;
}

void VolumeLook::Frame::scale(float factor) {
  for (Vec3f* column : {&bottom_s, &bottom_t, &top_s, &top_t}) *column *= factor;
}

// Of sums with these weights.
bool VolumeLook::is_alike(const Frame& a, float weight_a, const Frame& b, float weight_b) {
  constexpr float k_share = 0.3f;  // of the length
  const auto near = [&](const Vec3f& x, const Vec3f& y) {
    return (x / weight_a - y / weight_b).norm() <= k_share * (x / weight_a).norm();
  };
  return weight_a > 0 && weight_b > 0 && near(a.bottom_s, b.bottom_s) && near(a.bottom_t, b.bottom_t);
}

void VolumeLook::set_frames() {
  // Corners of a vertex with the same texture coordinates share a frame: the mean of their triangles' by
  // area.
  std::vector<std::uint32_t> order(triangles_.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&](std::uint32_t c) { return std::tuple(triangles_[c], places_[c].x(), places_[c].y()); };
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return std::tuple(key(a), a) < std::tuple(key(b), b); });
  const std::size_t n_triangles = triangles_.size() / 3;
  std::vector<Frame> of_triangles(n_triangles);
  std::vector<float> areas(n_triangles);
  for (std::uint32_t t = 0; t < n_triangles; ++t) {
    const LayerCell prism = this->prism(t);
    const Vec2 st_u = prism.st[1] - prism.st[0], st_v = prism.st[2] - prism.st[0];
    const double det = st_u.x() * st_v.y() - st_u.y() * st_v.x();
    if (det == 0) continue;
    const auto along = [&](double height, int axis) {
      const Vec3 u = prism.corner(1, height) - prism.corner(0, height),
                 v = prism.corner(2, height) - prism.corner(0, height);
      return axis == 0 ? Vec3((st_v.y() * u - st_u.y() * v) / det)
                       : Vec3((st_u.x() * v - st_v.x() * u) / det);
    };
    of_triangles[t] = {along(0, 0).cast<float>(), along(0, 1).cast<float>(), along(1, 0).cast<float>(),
                       along(1, 1).cast<float>()};
    areas[t] = static_cast<float>(prism.normal(0).norm());
  }
  // Groups of a vertex, one after the other.
  struct Group {
    std::size_t first, last;  // in `order`
    Frame sum;
    float weight = 0;
  };
  std::vector<Group> groups;
  frames_.resize(triangles_.size());
  for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
    groups.clear();
    const std::uint32_t vertex = triangles_[order[first]];
    for (; last < order.size() && triangles_[order[last]] == vertex; ++last) {
      if (groups.empty() || key(order[groups.back().first]) != key(order[last]))
        groups.push_back({last, last, {}});
      const std::uint32_t t = order[last] / 3;
      groups.back().sum.add(areas[t], of_triangles[t]);
      groups.back().weight += areas[t];
      groups.back().last = last + 1;
    }
    for (const Group& group : groups) {
      Frame frame = group.sum;
      float weight = group.weight;
      for (const Group& other : groups) {
        // A seam that the texture goes on across, as where it closes around a body.
        if (&other == &group || !is_alike(group.sum, group.weight, other.sum, other.weight)) continue;
        frame.add(1, other.sum);
        weight += other.weight;
      }
      if (weight > 0) frame.scale(1 / weight);
      for (std::size_t i = group.first; i < group.last; ++i) frames_[order[i]] = frame;
    }
  }
}

void VolumeLook::set_texels() {
  const std::array<int, 3>& size = texture_->surfaces.front().size;
  for (std::uint32_t c = 0; c < n_primitives(); ++c) {
    const LayerCell cell = this->cell(c);
    const std::size_t last = cell.n_corners - 1;
    const Vec2 across = cell.st[last - 1] - cell.st[0], back = cell.st[last] - cell.st[last - 2];
    const double area = cell.normal(0).norm(),
                 texels = std::abs(across.x() * back.y() - across.y() * back.x()) * size[0] * size[1];
    const double side = texels > 0 ? std::sqrt(area / texels) : std::sqrt(area);
    double height = 0;
    for (std::size_t k = 0; k < cell.n_corners; ++k)
      height += cell.directors[k].norm() / static_cast<double>(cell.n_corners);
    footprints_.push_back(static_cast<float>(side));
    texels_.push_back(static_cast<float>(std::min(side, height / size[2])));
  }
}

LayerCell VolumeLook::cell_of(std::span<const std::uint32_t> corners) const {
  LayerCell cell;
  cell.n_corners = corners.size();
  for (std::size_t k = 0; k < corners.size(); ++k) {
    cell.vertices[k] = triangles_[corners[k]];
    cell.bottoms[k] = bottoms_[cell.vertices[k]];
    cell.directors[k] = directors_[cell.vertices[k]];
    cell.st[k] = places_[corners[k]];
  }
  return cell;
}

LayerCell VolumeLook::cell(std::uint32_t primitive) const {
  const CellCorners& corners = cells_[primitive];
  LayerCell cell = cell_of(std::span(corners.corners).first(corners.n));
  cell.primitive = primitive;
  return cell;
}

LayerCell VolumeLook::prism(std::uint32_t triangle) const {
  return cell_of(std::array{3 * triangle, 3 * triangle + 1, 3 * triangle + 2});
}

Box3 VolumeLook::bounds(std::uint32_t primitive) const {
  const LayerCell cell = this->cell(primitive);
  Box3 box;
  for (std::size_t k = 0; k < cell.n_corners; ++k) box.extend(cell.corner(k, 0)).extend(cell.corner(k, 1));
  return box;
}

VolumeLook::Choice VolumeLook::choose(std::uint32_t primitive, const VolumeRay& ray, double distance) const {
  if (!view_) return {false, 0};
  const double pixel = view_->pixel_angle * (ray.at(distance) - view_->eye).norm();
  const double level =
      std::log2(std::max(pixel, 1e-30) / std::max(static_cast<double>(footprints_[primitive]), 1e-30)) +
      hashed_number(ray.key, 0);
  const int whole = static_cast<int>(std::floor(std::clamp(level, 0.0, 64.0)));
  if (whole < texture_->first_transparent()) return {false, whole};
  if (texture_->transparent.empty()) return {false, texture_->first_transparent()};
  return {true, std::min(whole - texture_->first_transparent(),
                         static_cast<int>(texture_->transparent.size()) - 1)};
}

Rgb VolumeLook::color_at(const Hit& hit, const Vec3f& direction) const {
  const VolumeTexture& finest = texture_->surfaces.front();
  if (finest.colors.empty()) return color_;
  const LayerCell cell = this->cell(hit.part.primitive);
  const VolumeRay ray(hit.origin, direction);
  const auto distance = static_cast<double>(hit.distance);
  CellPlace place{{static_cast<double>(hit.u), static_cast<double>(hit.v)}, 0};
  const Vec3 bottom = cell.point(place), director = cell.jacobian(place).col(2);
  place.height = std::clamp((ray.at(distance) - bottom).dot(director) / director.squaredNorm(), 0.0, 1.0);
  const Choice choice = choose(hit.part.primitive, ray, distance);
  const Vec3 at = cell.texture(place);
  if (!choice.is_matter)
    return sampled_color(texture_->surfaces[static_cast<std::size_t>(choice.level)], at).cast<float>();
  const TransparentVolume& matter = texture_->transparent[static_cast<std::size_t>(choice.level)];
  const Vec3 step = cell.texture_step(place, cell.follow(ray, distance, place));
  const Vec3 factors = matter.correction_along(step.cwiseProduct(finest.extent).stableNormalized()).color;
  const Vec3 color = linear_color(number_of(matter.colors.at(matter.texel_at(at, finest.is_periodic))));
  return factors.cwiseProduct(color).cast<float>();
}

RTCGeometry volume_geometry(RTCDevice device, const VolumeLook& look) {
  return UserGeometry<VolumeLook>::make(device, look);
}

}  // namespace detail

}  // namespace recede
