#include <recede/geometry/error.h>
#include <recede/lod/detail/grid_space.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace recede::detail {
namespace {

/// Voxels across the picture, and steps for a doubled depth: places fit 32 bits with room, whatever the
/// depth.
constexpr double k_most_voxels = 1 << 20;
/// Edges of more voxels are halved: patches stay small enough for caches, and are enough for all cores.
constexpr double k_longest_edge = 256;

void check(const RemeshView& view, double voxel_pixels, double nearest) {
  const auto require = [](bool holds, const char* what) {
    if (!holds) throw OptionError(what);
  };
  const auto is_positive = [](double value) { return value > 0 && std::isfinite(value); };
  require(view.position.allFinite() && view.target.allFinite() && (view.target - view.position).norm() > 0,
          "the position and the target of a view must be finite and apart");
  require(view.up.allFinite(), "the upward direction of a view must be finite");
  require(view.field_of_view > 0 && view.field_of_view < std::numbers::pi,
          "the field of view must lie between 0 and 180 degrees");
  require(view.width >= 1 && view.height >= 1, "the image needs at least one pixel a side");
  require(is_positive(voxel_pixels), "the size of triangles in pixels must be positive");
  require(is_positive(nearest), "the nearest depth must be positive");
}

}  // namespace

GridSpace::GridSpace(const RemeshView& view, double voxel_pixels, double nearest)
    : eye_(view.position), nearest_(nearest) {
  check(view, voxel_pixels, nearest);
  forward_ = (view.target - view.position).normalized();
  const Vec3 right = forward_.cross(view.up);
  // Below this sine the view runs along `up`, and the image has no upright of its own.
  constexpr double k_parallel = 1e-9;
  const bool upright = right.norm() > k_parallel * view.up.norm();
  right_ = upright ? Vec3(right.normalized()) : Vec3(forward_.unitOrthogonal());
  down_ = forward_.cross(right_);
  const double half = std::tan(view.field_of_view / 2);
  voxel_ = voxel_pixels * 2 * half / view.height;
  log_step_ = std::log1p(2 * half / view.height) * voxel_pixels;
  middle_ = Vec2(view.width, view.height) / (2 * voxel_pixels);
  tangent_ = Vec2(half * view.width / view.height, half);
  // Half a picture around the picture is diced as finely as the picture itself.
  const double beyond = middle_.maxCoeff();
  least_ = Vec2::Constant(-beyond);
  largest_ = 2 * middle_ + Vec2::Constant(beyond);
  if (!(largest_.maxCoeff() < k_most_voxels) || !(1 / log_step_ < k_most_voxels)) {
    throw OptionError("the triangles are too small for the image: more than a million across");
  }
}

ViewPoint GridSpace::view(const Vec3& point) const {
  const Vec3 from_eye = point - eye_;
  const double x = from_eye.dot(right_), y = from_eye.dot(down_), z = from_eye.dot(forward_);
  ViewPoint seen;
  seen.depth = std::max(z, nearest_);
  seen.grid = {middle_.x() + x / (seen.depth * voxel_), middle_.y() + y / (seen.depth * voxel_),
               steps_to(seen.depth)};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto k = static_cast<Eigen::Index>(axis);
    seen.voxel[axis] = static_cast<std::int32_t>(rounded(std::clamp(seen.grid[k], least_[k], largest_[k])));
    const double side = axis == 0 ? x : y, slant = std::hypot(1.0, tangent_[k]);
    seen.beyond[2 * axis] = (-side - z * tangent_[k]) / slant;
    seen.beyond[2 * axis + 1] = (side - z * tangent_[k]) / slant;
  }
  seen.voxel[2] = static_cast<std::int32_t>(rounded(seen.grid.z()));
  seen.beyond[4] = -z;
  return seen;
}

bool GridSpace::is_uneven(const ViewPoint& a, const ViewPoint& b, double largest_depth_ratio) const {
  if (std::max(a.depth, b.depth) > largest_depth_ratio * std::min(a.depth, b.depth)) return true;
  if (main_direction(a.voxel, b.voxel).length > k_longest_edge) return true;
  constexpr double k_few = 4;  // voxels: not worth another patch
  for (const Eigen::Index axis : {0, 1}) {
    const auto part = [&](double at) { return at < least_[axis] ? -1 : at > largest_[axis] ? 1 : 0; };
    if (part(a.grid[axis]) == part(b.grid[axis])) continue;
    const auto inside = [&](double at) { return std::clamp(at, least_[axis], largest_[axis]); };
    const double length = std::abs(a.grid[axis] - b.grid[axis]);
    const double kept = std::abs(inside(a.grid[axis]) - inside(b.grid[axis]));
    if (length > k_few && kept < 0.5 * length) return true;
  }
  return false;
}

MainDirection main_direction(const GridPoint& a, const GridPoint& b) {
  MainDirection main;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int32_t length = std::abs(b[axis] - a[axis]);
    if (length > main.length) main = {axis, length};
  }
  return main;
}

}  // namespace recede::detail
