#include <recede/geometry/detail/plane_predicates.h>
#include <recede/lod/detail/plane_hulls.h>

#include <algorithm>
#include <array>

namespace recede::detail {

namespace {

using Hull = std::vector<Vec2>;

// Along a line that is the order of its points.
bool is_before(const Vec2& a, const Vec2& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); }

// Whether all points lie beside the line through `a` and `b`, on the side that `sign` says.
bool are_beside(const Vec2& a, const Vec2& b, const Hull& points, int sign) {
  return std::all_of(points.begin(), points.end(),
                     [&](const Vec2& point) { return orientation(a, b, point) == sign; });
}

// Whether a side of the first hull parts it from the other one.
bool is_parted_by_side(const Hull& hull, const Hull& other) {
  if (hull.size() < 2) return false;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    if (are_beside(hull[i], hull[(i + 1) % hull.size()], other, -1)) return true;
  }
  return false;
}

// All that has at most two points, on the same line.
bool are_on_a_line(const Hull& a, const Hull& b) {
  if (a.size() > 2 || b.size() > 2) return false;
  return are_beside(a.front(), a.back(), b, 0) && are_beside(b.front(), b.back(), a, 0);
}

bool is_inside(const Hull& hull, const Vec2& point) {
  if (hull.size() < 3) return false;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    if (orientation(hull[i], hull[(i + 1) % hull.size()], point) <= 0) return false;
  }
  return true;
}

// Whether two points are seen in the same direction from a third.
bool is_same_direction(const Vec2& from, const Vec2& a, const Vec2& b) {
  return orientation(from, a, b) == 0 && is_before(from, a) == is_before(from, b);
}

// All directions from a point that is in a hull, but not inside, to the rest of it: from `first`
// counter-clockwise to `last`, half a turn at most.
struct Fan {
  Vec2 first, last;
  bool is_empty = true;
};

Fan fan_from(const Vec2& point, const Hull& hull) {
  Fan fan;
  // Twice, for one of two ends of half a turn may come when there is nothing between them yet.
  for (int round = 0; round < 2; ++round) {
    for (const Vec2& corner : hull) {
      if (corner == point) continue;
      if (fan.is_empty) fan = {corner, corner, false};
      if (orientation(point, fan.first, corner) < 0) fan.first = corner;
      if (orientation(point, fan.last, corner) > 0) fan.last = corner;
    }
  }
  return fan;
}

// Whether the direction to `to` is one of the hull's, of which `from` is a point.
bool is_toward(const Vec2& from, const Hull& hull, const Vec2& to) {
  if (is_inside(hull, from)) return true;
  // Of a line, which may reach to both sides.
  if (hull.size() == 2) {
    return std::any_of(hull.begin(), hull.end(),
                       [&](const Vec2& end) { return end != from && is_same_direction(from, end, to); });
  }
  const Fan fan = fan_from(from, hull);
  if (fan.is_empty) return false;
  const int after_first = orientation(from, fan.first, to), after_last = orientation(from, fan.last, to);
  if (after_first == 0 && is_same_direction(from, fan.first, to)) return true;
  if (after_last == 0 && is_same_direction(from, fan.last, to)) return true;
  return after_first > 0 && after_last < 0;
}

bool is_any_toward(const Vec2& from, const Hull& hull, const Hull& others) {
  return std::any_of(others.begin(), others.end(),
                     [&](const Vec2& other) { return other != from && is_toward(from, hull, other); });
}

}  // namespace

std::vector<Vec2> convex_hull(std::vector<Vec2> points) {
  std::sort(points.begin(), points.end(), is_before);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Vec2> hull;
  for (int half = 0; half < 2; ++half) {
    const std::size_t first = hull.size();
    for (const Vec2& point : points) {
      while (hull.size() >= first + 2 && orientation(hull[hull.size() - 2], hull.back(), point) <= 0)
        hull.pop_back();
      hull.push_back(point);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

bool hulls_meet(const std::vector<Vec2>& a, const std::vector<Vec2>& b) {
  if (are_on_a_line(a, b)) {
    const auto [first_a, last_a] = std::minmax(a.front(), a.back(), is_before);
    const auto [first_b, last_b] = std::minmax(b.front(), b.back(), is_before);
    return !is_before(last_a, first_b) && !is_before(last_b, first_a);
  }
  return !is_parted_by_side(a, b) && !is_parted_by_side(b, a);
}

bool hulls_overlap_beside(const std::vector<Vec2>& a, const std::vector<Vec2>& b, const Vec2& common) {
  // What both have begins with an end of one of them.
  return is_any_toward(common, a, b) || is_any_toward(common, b, a);
}

}  // namespace recede::detail
