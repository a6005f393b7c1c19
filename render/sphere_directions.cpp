#include <recede/geometry/error.h>
#include <recede/render/sphere_directions.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;

/// The convex hull of points on a sphere, one point after another: the triangles that see it go, and those
/// between it and their outline come. Takes time in proportion to the square of the number of points.
class SphereHull {
 public:
  explicit SphereHull(std::span<const Vec3> points) : points_(points) {
    start_with_tetrahedron();
    for (std::int32_t point = 4; point < static_cast<std::int32_t>(points.size()); ++point) add(point);
  }

  std::vector<DirectionTriangle> take() { return std::move(triangles_); }

 private:
  const Vec3& at(std::int32_t point) const { return points_[static_cast<std::size_t>(point)]; }
  bool sees(std::int32_t point, const DirectionTriangle& t) const {
    const Vec3 &a = at(t[0]), &b = at(t[1]), &c = at(t[2]);
    return (b - a).cross(c - a).dot(at(point) - a) > 0;
  }

  void start_with_tetrahedron() {
    for (std::int32_t left_out = 0; left_out < 4; ++left_out) {
      DirectionTriangle t{};
      for (std::int32_t k = 0, corner = 0; corner < 4; ++corner) {
        if (corner != left_out) t[static_cast<std::size_t>(k++)] = corner;
      }
      if (sees(left_out, t)) std::swap(t[1], t[2]);
      triangles_.push_back(t);
    }
  }

  void add(std::int32_t point) {
    std::vector<std::pair<std::int32_t, std::int32_t>> edges;  // of triangles that go
    std::vector<DirectionTriangle> kept;
    for (const DirectionTriangle& t : triangles_) {
      if (!sees(point, t)) {
        kept.push_back(t);
        continue;
      }
      for (std::size_t k = 0; k < 3; ++k) edges.emplace_back(t[k], t[(k + 1) % 3]);
    }
    for (const auto& [from, to] : edges) {
      const bool inside = std::find(edges.begin(), edges.end(), std::pair(to, from)) != edges.end();
      if (!inside) kept.push_back({from, to, point});
    }
    triangles_ = std::move(kept);
  }

  std::span<const Vec3> points_;
  std::vector<DirectionTriangle> triangles_;
};

/// Where a direction passes a triangle: the shares of its corners, of which one is negative when it passes by
/// outside; {-1, -1, -1} behind it.
std::array<double, 3> shares_in(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& direction) {
  const double x = direction.dot(b.cross(c)), y = direction.dot(c.cross(a)), z = direction.dot(a.cross(b));
  const double sum = x + y + z;
  if (!(sum > 0)) return {-1, -1, -1};
  return {x / sum, y / sum, z / sum};
}

double least(const std::array<double, 3>& shares) { return *std::min_element(shares.begin(), shares.end()); }

}  // namespace

SphereDirections spread_directions(int count) {
  constexpr int k_least = 6, k_most = 4096;
  if (count < k_least || count > k_most)
    throw OptionError(fmt::format("directions over a sphere: {} to {}, not {}", k_least, k_most, count));
  constexpr double k_golden_angle = k_pi * (3 - 2.2360679774997896964);  // 3 - the root of 5
  SphereDirections sphere;
  for (int i = 0; i < count; ++i) {
    // A level ray passes over thousands of copies of a map before it leaves the layer of its heights.
    const double height = 2 * i + 1 == count ? 0.5 / count : 1 - (2.0 * i + 1) / count;
    const double level = std::sqrt(1 - height * height), azimuth = i * k_golden_angle;
    sphere.directions.emplace_back(level * std::cos(azimuth), level * std::sin(azimuth), height);
  }
  sphere.triangles = SphereHull(sphere.directions).take();
  return sphere;
}

std::size_t nearest_direction(std::span<const Vec3> directions, const Vec3& direction) {
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < directions.size(); ++i) {
    if (directions[i].dot(direction) > directions[nearest].dot(direction)) nearest = i;
  }
  return nearest;
}

DirectionMix mix_of_three(std::span<const Vec3> directions, std::span<const DirectionTriangle> triangles,
                          const Vec3& direction) {
  DirectionMix best;
  double best_least = -2;
  for (const DirectionTriangle& t : triangles) {
    const auto at = [&](std::size_t k) -> const Vec3& { return directions[static_cast<std::size_t>(t[k])]; };
    const std::array<double, 3> shares = shares_in(at(0), at(1), at(2), direction);
    if (!(least(shares) > best_least)) continue;
    best_least = least(shares);
    best = {t, shares};
    if (best_least >= 0) return best;
  }
  // Between triangles by rounding, or where moved ones leave a gap: the nearest of them.
  double sum = 0;
  for (double& weight : best.weights) sum += weight = std::max(weight, 0.0);
  for (double& weight : best.weights) weight = sum > 0 ? weight / sum : 1.0 / 3;
  return best;
}

std::vector<double> solid_angles(std::span<const Vec3> directions,
                                 std::span<const DirectionTriangle> triangles) {
  std::vector<double> angles(directions.size(), 0.0);
  for (const DirectionTriangle& t : triangles) {
    const auto at = [&](std::size_t k) -> const Vec3& { return directions[static_cast<std::size_t>(t[k])]; };
    const Vec3 &a = at(0), &b = at(1), &c = at(2);
    // Van Oosterom and Strackee 1983, "The solid angle of a plane triangle".
    const double angle = 2 * std::atan2(a.dot(b.cross(c)), 1 + a.dot(b) + b.dot(c) + c.dot(a));
    for (const std::int32_t corner : t) angles[static_cast<std::size_t>(corner)] += std::max(angle, 0.0) / 3;
  }
  return angles;
}

}  // namespace recede
