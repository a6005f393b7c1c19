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
constexpr std::int32_t k_longest_edge = 256;
/// Edges of so few are too short for their pieces to differ.
constexpr std::int32_t k_few_voxels = 4;
/// A point outside of the pyramid of view counts as this many times farther as it is beyond it: what lies
/// behind the eye is some eight times coarser than what is seen as far away.
constexpr double k_coarser = 8;
/// Points move into the picture from beside it, but those that are farther beside it than this share of their
/// distance aren't made finer for that: near the eye everything may move before it.
constexpr double k_slack = 0.25;

void check(const RemeshView& view, double voxel_pixels, double nearest) {
  const auto require = [](bool holds, const char* what) {
    if (!holds) throw OptionError(what);
  };
  const auto is_positive = [](double value) { return value > 0 && std::isfinite(value); };
  require(view.position.allFinite() && view.target.allFinite() && (view.target - view.position).norm() > 0,
          "the position and the target of a view must be finite and apart");
  // Squares of longer things overflow.
  require(std::max(view.position.norm(), view.target.norm()) < 1e150,
          "the position and the target of a view must be less than 1e150 from the origin");
  require(view.up.allFinite(), "the upward direction of a view must be finite");
  require(view.field_of_view > 0 && view.field_of_view < std::numbers::pi,
          "the field of view must lie between 0 and 180 degrees");
  require(view.width >= 1 && view.height >= 1, "the image needs at least one pixel a side");
  require(is_positive(voxel_pixels), "the size of triangles in pixels must be positive");
  require(is_positive(nearest), "the nearest depth must be positive");
}

}  // namespace

GridSpace::GridSpace(const RemeshView& view, double voxel_pixels, double nearest, double reach)
    : eye_(view.position), nearest_(nearest), reach_(reach) {
  check(view, voxel_pixels, nearest);
  forward_ = (view.target - view.position).normalized();
  const Vec3 right = forward_.cross(view.up.stableNormalized());
  // Below this sine the view runs along `up`, and the image has no upright of its own.
  constexpr double k_parallel = 1e-9;
  const bool upright = right.norm() > k_parallel;
  right_ = upright ? Vec3(right.normalized()) : Vec3(forward_.unitOrthogonal());
  down_ = forward_.cross(right_);
  const double half = std::tan(view.field_of_view / 2);
  voxel_ = voxel_pixels * 2 * half / view.height;
  log_step_ = std::log1p(2 * half / view.height) * voxel_pixels;
  middle_ = Vec2(view.width, view.height) / (2 * voxel_pixels);
  tangent_ = Vec2(half * view.width / view.height, half);
  least_share_ = 0.5 / std::sqrt(1 + tangent_.squaredNorm());  // half that in the picture's corners
  if (!(2 * middle_.maxCoeff() < k_most_voxels) || !(1 / log_step_ < k_most_voxels)) {
    throw OptionError("the triangles are too small for the image: more than a million across");
  }
}

ViewPoint GridSpace::view(const Vec3& point) const {
  const Vec3 from_eye = point - eye_;
  const double x = from_eye.dot(right_), y = from_eye.dot(down_), z = from_eye.dot(forward_);
  ViewPoint seen;
  seen.from_eye = from_eye;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const double side = axis == 0 ? x : y, tangent = tangent_[static_cast<Eigen::Index>(axis)];
    const double slant = std::hypot(1.0, tangent);
    seen.beyond[2 * axis] = (-side - z * tangent) / slant;
    seen.beyond[2 * axis + 1] = (side - z * tangent) / slant;
  }
  seen.beyond[4] = -z;
  const double distance = from_eye.norm();
  seen.slack = std::min(reach_, k_slack * distance);
  seen.true_depth = std::max({nearest_, z, least_share_ * distance});
  const double outside = *std::max_element(seen.beyond.begin(), seen.beyond.end()) - seen.slack;
  seen.depth = seen.true_depth + k_coarser * std::max(0.0, outside);
  const std::array<double, 3> at{middle_.x() + x / (seen.depth * voxel_),
                                 middle_.y() + y / (seen.depth * voxel_), steps_to(seen.depth)};
  for (std::size_t axis = 0; axis < 3; ++axis)
    seen.voxel[axis] = static_cast<std::int32_t>(rounded(at[axis]));
  return seen;
}

bool GridSpace::is_uneven(const ViewPoint& a, const ViewPoint& b, double largest_depth_ratio) const {
  // The longest side of a triangle is no farther than its altitude from what the triangle shows of itself,
  // even when all sides are outside the picture.
  constexpr double k_altitude = 0.8661;  // over the longest side, at most: sqrt(3) / 2
  const double length = (b.from_eye - a.from_eye).norm();
  if (is_unseen(std::max({a.slack, b.slack, k_altitude * length}), a, b)) return false;
  const std::int32_t voxels = main_direction(a.voxel, b.voxel).length;
  if (voxels > k_longest_edge) return true;
  const double ratio = std::max(a.depth, b.depth) / std::min(a.depth, b.depth);
  if (voxels > k_few_voxels && ratio > largest_depth_ratio) return true;
  const double true_voxel = voxel_size(std::min(a.true_depth, b.true_depth));
  const bool is_outside = std::max(a.depth / a.true_depth, b.depth / b.true_depth) > largest_depth_ratio;
  return is_outside && length > k_few_voxels * true_voxel;
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
