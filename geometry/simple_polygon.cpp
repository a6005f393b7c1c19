#include <recede/geometry/detail/plane_predicates.h>
#include <recede/geometry/detail/simple_polygon.h>

#include <algorithm>
#include <numeric>

namespace recede::detail {
namespace {

/// Segments with overlapping x ranges have a common point.
bool touch(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  if (std::max(a.y(), b.y()) < std::min(c.y(), d.y()) || std::max(c.y(), d.y()) < std::min(a.y(), b.y())) {
    return false;
  }
  return orientation(a, b, c) * orientation(a, b, d) <= 0 && orientation(c, d, a) * orientation(c, d, b) <= 0;
}

/// The side from b to c runs back along the one from a to b.
bool runs_back(const Vec2& a, const Vec2& b, const Vec2& c) {
  return b == c || (orientation(a, b, c) == 0 && (a - b).dot(c - b) > 0);
}

}  // namespace

bool is_simple_polygon(const std::vector<Vec2>& corners) {
  const std::size_t n = corners.size();
  if (n < 3) return false;
  const auto end = [&](std::size_t side) -> const Vec2& { return corners[(side + 1) % n]; };
  const auto left = [&](std::size_t side) { return std::min(corners[side].x(), end(side).x()); };
  const auto right = [&](std::size_t side) { return std::max(corners[side].x(), end(side).x()); };
  std::vector<std::size_t> order(n), active;
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return left(a) < left(b); });
  for (const std::size_t side : order) {
    if (runs_back(corners[side], end(side), end((side + 1) % n))) return false;
    std::erase_if(active, [&](std::size_t other) { return right(other) < left(side); });
    for (const std::size_t other : active) {
      if ((other + 1) % n == side || (side + 1) % n == other) continue;
      if (touch(corners[side], end(side), corners[other], end(other))) return false;
    }
    active.push_back(side);
  }
  return true;
}

}  // namespace recede::detail
