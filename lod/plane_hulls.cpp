#include <recede/lod/detail/plane_hulls.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace recede::detail {

namespace {

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

// Whether a direction, as the normal of a line, parts the hulls.
bool parts(const Vec2& normal, const std::vector<Vec2>& a, const std::vector<Vec2>& b) {
  const auto range = [&](const std::vector<Vec2>& hull) {
    double least = INFINITY, most = -INFINITY;
    for (const Vec2& point : hull) {
      least = std::min(least, normal.dot(point));
      most = std::max(most, normal.dot(point));
    }
    return std::pair(least, most);
  };
  const auto [least_a, most_a] = range(a);
  const auto [least_b, most_b] = range(b);
  return most_a < least_b || most_b < least_a;
}

bool parted_by_sides(const std::vector<Vec2>& of, const std::vector<Vec2>& a, const std::vector<Vec2>& b) {
  for (std::size_t i = 0; i < of.size(); ++i) {
    const Vec2 side = of[(i + 1) % of.size()] - of[i];
    if (parts(Vec2(side.y(), -side.x()), a, b)) return true;
    // Along lines too, which have no inside.
    if (of.size() == 2 && parts(side, a, b)) return true;
  }
  return false;
}

// The directions from a point to all of a hull, less than half a turn of them: where they begin,
// counter-clockwise, and how far they reach.
struct Fan {
  double begin, width;
};

Fan fan_from(const Vec2& point, const std::vector<Vec2>& hull) {
  std::vector<double> angles;
  for (const Vec2& corner : hull) {
    const Vec2 to = corner - point;
    if (to.squaredNorm() > 0) angles.push_back(std::atan2(to.y(), to.x()));
  }
  if (angles.empty()) return {0, 0};
  std::sort(angles.begin(), angles.end());
  // The widest gap between neighbours is outside.
  double widest = angles.front() + 2 * std::numbers::pi - angles.back();
  double begin = angles.front();
  for (std::size_t i = 0; i + 1 < angles.size(); ++i) {
    if (angles[i + 1] - angles[i] > widest) {
      widest = angles[i + 1] - angles[i];
      begin = angles[i + 1];
    }
  }
  return {begin, 2 * std::numbers::pi - widest};
}

}  // namespace

std::vector<Vec2> convex_hull(std::vector<Vec2> points) {
  const auto less = [](const Vec2& a, const Vec2& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  };
  std::sort(points.begin(), points.end(), less);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Vec2> hull;
  for (int half = 0; half < 2; ++half) {
    const std::size_t first = hull.size();
    for (const Vec2& point : points) {
      while (hull.size() >= first + 2 && cross(hull.back() - hull[hull.size() - 2], point - hull.back()) <= 0)
        hull.pop_back();
      hull.push_back(point);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

bool hulls_meet(const std::vector<Vec2>& a, const std::vector<Vec2>& b) {
  if (a.size() == 1 && b.size() == 1) return a[0] == b[0];
  return !parted_by_sides(a, a, b) && !parted_by_sides(b, a, b);
}

bool hulls_overlap_beside(const std::vector<Vec2>& a, const std::vector<Vec2>& b, const Vec2& common) {
  const Fan one = fan_from(common, a), two = fan_from(common, b);
  // From where the first begins, counter-clockwise.
  double offset = std::fmod(two.begin - one.begin, 2 * std::numbers::pi);
  if (offset < 0) offset += 2 * std::numbers::pi;
  return offset <= one.width || offset + two.width >= 2 * std::numbers::pi;
}

}  // namespace recede::detail
