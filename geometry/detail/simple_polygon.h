// Whether a polygon touches itself, decided without rounding.
#pragma once

#include <recede/geometry/vec.h>

#include <vector>

namespace recede::detail {

/// Whether the closed polygon has at least three corners and its sides meet at common corners only. A sweep
/// over the sides, decided by exact signs.
bool is_simple_polygon(const std::vector<Vec2>& corners);

}  // namespace recede::detail
