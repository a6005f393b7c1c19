// Convex hulls in the plane, and whether they meet.
#pragma once

#include <recede/geometry/vec.h>

#include <vector>

namespace recede::detail {

/// Counter-clockwise, without points within sides. Of points on a line: its ends; of equal points: one.
std::vector<Vec2> convex_hull(std::vector<Vec2> points);

/// Whether hulls have a point in common.
bool hulls_meet(const std::vector<Vec2>& a, const std::vector<Vec2>& b);

/// Whether hulls with the point `common` of both have another one in common.
bool hulls_overlap_beside(const std::vector<Vec2>& a, const std::vector<Vec2>& b, const Vec2& common);

}  // namespace recede::detail
