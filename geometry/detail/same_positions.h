// Vertices that stand at one place.
#pragma once

#include <recede/geometry/polygon_soup.h>

namespace recede::detail {

/// For each vertex the lowest vertex at the same position (-0 equals 0). Open addressing over a flat table:
/// no allocation per vertex.
std::vector<Index> lowest_at_same_position(const std::vector<Vec3>& positions);

}  // namespace recede::detail
