// An order of points in which the next one is near.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <cstdint>
#include <span>
#include <vector>

namespace recede::detail {

/// The points' numbers along Hilbert's curve through 1024^3 cells of a cube around them; those of a cell as
/// they came. Points may be anything, those that aren't finite too.
std::vector<std::uint32_t> near_order(std::span<const Vec3> points);

}  // namespace recede::detail
