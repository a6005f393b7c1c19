#include <recede/geometry/error.h>
#include <recede/render/displaced_plane.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede {
namespace {

constexpr int k_most_copies = 65'536;
constexpr double k_infinite = std::numeric_limits<double>::infinity();

const DisplacementMap& checked(const DisplacementMap& map, const Vec2& sides) {
  if (map.border() != MapBorder::periodic)
    throw InputError("a displaced plane needs a periodic map: copies of another don't fit together");
  if (!sides.allFinite() || !(sides.minCoeff() > 0))
    throw OptionError("the sides of a map are lengths greater than 0");
  return map;
}

/// t where a ray leaves the layer of all heights, the start of which it must have reached at t >= 0; less
/// than `enter` when it misses the layer.
struct Layer {
  double enter = 0, leave = k_infinite;
};
Layer layer_along(double start, double step, const HeightRange& heights) {
  const double reach = std::max({std::abs(start), std::abs(heights.min), std::abs(heights.max)});
  const double slack = 8 * std::numeric_limits<double>::epsilon() * reach;  // of the places along the ray
  const double lower = heights.min - slack, upper = heights.max + slack;
  if (step == 0) return start >= lower && start <= upper ? Layer{} : Layer{0, -1};
  const double a = (lower - start) / step, b = (upper - start) / step;
  return {std::max(0.0, std::min(a, b)), std::max(a, b)};
}

/// t where a ray comes to the next line between copies along one axis.
double end_of_copy(double copy, double start, double step) {
  if (step == 0) return k_infinite;
  return (copy + (step > 0 ? 1 : 0) - start) / step;
}

}  // namespace

DisplacedPlane::DisplacedPlane(const DisplacementMap& map, const Vec2& sides, PlaneNormals normals)
    : field_(checked(map, sides)), sides_(sides), normals_(normals) {
  heights_ = field_.bounds().node(field_.bounds().levels() - 1, 0, 0);
}

/// Copies in the order in which a ray passes over them, each with the ray moved into the square of the map:
/// `visit(start, step)` until one says that it is enough.
template <class Visit>
void DisplacedPlane::visit_copies(const Vec3& origin, const Vec3& direction, const Visit& visit) const {
  const Vec3 lengths(sides_.x(), sides_.y(), 1);
  const Vec3 start = origin.cwiseQuotient(lengths), step = direction.cwiseQuotient(lengths);
  if (!start.allFinite() || !step.allFinite()) return;
  const Layer layer = layer_along(start.z(), step.z(), heights_);
  if (layer.enter > layer.leave) return;
  Vec3 copy = start + layer.enter * step;
  copy = Vec3(std::floor(copy.x()), std::floor(copy.y()), 0);
  for (int visited = 0; visited < k_most_copies; ++visited) {
    if (visit(Vec3(start - copy), step)) return;
    const double end_x = end_of_copy(copy.x(), start.x(), step.x());
    const double end_y = end_of_copy(copy.y(), start.y(), step.y());
    if (!(std::min(end_x, end_y) < layer.leave)) return;
    const Eigen::Index axis = end_x <= end_y ? 0 : 1;
    copy[axis] += step[axis] > 0 ? 1 : -1;
  }
}

std::optional<DisplacedPlane::Hit> DisplacedPlane::first_hit(const Vec3& origin,
                                                             const Vec3& direction) const {
  std::optional<Hit> found;
  visit_copies(origin, direction, [&](const Vec3& start, const Vec3& step) {
    if (const auto hit = field_.first_hit(start, step)) {
      // Slopes along x and y are those along u and v over the sides.
      const Vec3 lengths(sides_.x(), sides_.y(), 1);
      found = Hit{hit->t, hit->uv,
                  normals_ == PlaneNormals::smooth ? normal_at(hit->uv)
                                                   : Vec3(hit->normal.cwiseQuotient(lengths).normalized())};
    }
    return found.has_value();
  });
  return found;
}

bool DisplacedPlane::is_hit(const Vec3& origin, const Vec3& direction) const {
  bool found = false;
  visit_copies(origin, direction,
               [&](const Vec3& start, const Vec3& step) { return found = field_.is_hit(start, step); });
  return found;
}

Vec3 DisplacedPlane::normal_at(const Vec2& uv) const {
  const Vec2 step =
      normals_ == PlaneNormals::smooth ? map().smooth_derivative_at(uv) : map().derivative_at(uv);
  const Vec2 slope = step.cwiseQuotient(sides_);
  return Vec3(-slope.x(), -slope.y(), 1).normalized();
}

}  // namespace recede
