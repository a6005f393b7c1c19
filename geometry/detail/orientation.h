// Which way three points in the plane turn, decided without rounding.
#pragma once

#include <recede/geometry/vec.h>

#include <vector>

namespace recede::detail {

/// 1 when a, b, c turn counter-clockwise, -1 when clockwise, 0 when they lie on a line: the sign of the exact
/// determinant. A filter settles almost all cases (Shewchuk 1997, "Adaptive precision floating-point
/// arithmetic and fast robust geometric predicates"). Coordinates must keep their products between 1e-290 and
/// 1e300, or be 0.
int orientation(const Vec2& a, const Vec2& b, const Vec2& c);

/// Whether the closed polygon has at least three corners and its sides meet at common corners only. A sweep
/// over the sides, decided by exact signs.
bool is_simple_polygon(const std::vector<Vec2>& corners);

}  // namespace recede::detail
