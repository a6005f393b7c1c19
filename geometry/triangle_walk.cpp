#include <recede/geometry/detail/plane_predicates.h>
#include <recede/geometry/detail/triangle_walk.h>

namespace recede::detail {
namespace {

using On = TriangleLocation::On;

/// Sides of a triangle on whose lines a point lies.
struct SidesHit {
  int count = 0, sum = 0;
  void add(int side) {
    ++count;
    sum += side;
  }
};

TriangleLocation location_in(Index triangle, const SidesHit& hit) {
  if (hit.count == 0) return {On::face, triangle, 0};
  if (hit.count == 1) return {On::side, triangle, hit.sum};
  return {On::vertex, triangle, 3 - hit.sum};  // the corner that is opposite to neither
}

int orientation_at(const Vec2& point, const DelaunayTriangle& triangle, int side,
                   std::span<const Vec2> points) {
  return orientation(points[triangle.from(side)], points[triangle.to(side)], point);
}

}  // namespace

std::optional<TriangleLocation> walk_to(const Vec2& point, Index start, std::size_t most_steps,
                                        std::span<const Vec2> points,
                                        std::span<const DelaunayTriangle> triangles) {
  Index here = start;
  int entered = -1;
  // A changing order of the two other sides leads out of circles.
  std::uint32_t random = 1;
  for (std::size_t step = 0; step < most_steps; ++step) {
    const DelaunayTriangle& triangle = triangles[here];
    random = random * 1664525u + 1013904223u;
    const bool swap = (random >> 31) != 0;
    SidesHit hit;
    Index crossed = k_no_index;
    int side = entered < 0 || swap ? DelaunayTriangle::previous(entered < 0 ? 0 : entered)
                                   : DelaunayTriangle::next(entered);
    for (int n = entered < 0 ? 3 : 2; n > 0; --n) {
      const int sign = orientation_at(point, triangle, side, points);
      if (sign < 0) {
        crossed = triangle.side_across(side);
        if (crossed == k_no_index) return TriangleLocation{On::outside, here, side};
        break;
      }
      if (sign == 0) hit.add(side);
      side = entered < 0 || swap ? DelaunayTriangle::previous(side) : DelaunayTriangle::next(side);
    }
    if (crossed == k_no_index) return location_in(here, hit);
    here = crossed / 4;
    entered = static_cast<int>(crossed % 4);
    if (far_corner(triangles[here]) >= 0) return TriangleLocation{On::outside, here, 0};
  }
  return std::nullopt;
}

TriangleLocation look_everywhere(const Vec2& point, std::span<const Vec2> points,
                                 std::span<const DelaunayTriangle> triangles) {
  TriangleLocation outside;
  for (Index t = 0; t < triangles.size(); ++t) {
    const int far = far_corner(triangles[t]);
    if (far >= 0) {
      if (orientation_at(point, triangles[t], far, points) > 0) outside.triangle = t;
      continue;
    }
    SidesHit hit;
    int side = 0;
    for (; side < 3; ++side) {
      const int sign = orientation_at(point, triangles[t], side, points);
      if (sign < 0) break;
      if (sign == 0) hit.add(side);
    }
    if (side == 3) return location_in(t, hit);
  }
  return outside;
}

}  // namespace recede::detail
