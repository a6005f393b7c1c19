// A triangle cut by a plane.
#pragma once

#include <recede/geometry/closest_point.h>

#include <array>
#include <utility>

namespace recede::detail {

/// Calls `visit(Triangle, is_above)` for the one or two triangles above height 0 and those below. `heights`
/// are those of the corners. Both sides get the same points on the cut.
template <typename Visit>
void cut_triangle(const Triangle& triangle, const std::array<double, 3>& heights, Visit&& visit) {
  const std::array<Vec3, 3> corners{triangle.a, triangle.b, triangle.c};
  for (const double sign : {1.0, -1.0}) {
    std::array<Vec3, 4> part;
    std::size_t n = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      const double hi = sign * heights[i], hj = sign * heights[j];
      if (hi >= 0) part[n++] = corners[i];
      // Always from the lower corner to the upper one, so that both parts get the same point.
      if ((hi < 0) != (hj < 0) && hi != 0 && hj != 0) {
        const auto [low, high] = heights[i] < heights[j] ? std::pair{i, j} : std::pair{j, i};
        const double share = heights[low] / (heights[low] - heights[high]);
        part[n++] = corners[low] + share * (corners[high] - corners[low]);
      }
    }
    if (n >= 3) visit(Triangle{part[0], part[1], part[2]}, sign > 0);
    if (n == 4) visit(Triangle{part[0], part[2], part[3]}, sign > 0);
  }
}

/// The four triangles between the corners and the middles of the sides.
inline std::array<Triangle, 4> cut_in_four(const Triangle& t) {
  const Vec3 ab = 0.5 * (t.a + t.b), bc = 0.5 * (t.b + t.c), ca = 0.5 * (t.c + t.a);
  return {{{t.a, ab, ca}, {ab, t.b, bc}, {ca, bc, t.c}, {ab, bc, ca}}};
}

}  // namespace recede::detail
