// Whether triangles and tetrahedra with common vertices meet elsewhere. Decided by exact signs.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <array>
#include <span>

namespace recede::detail {

/// A triangle, or a tetrahedron, by the numbers of its corners. Those of a tetrahedron may lie in a plane:
/// then it is the quadrilateral around them.
struct Simplex {
  std::array<Index, 4> corners{};
  int size = 3;
};

/// Whether the two have a point in common that doesn't belong to the hull of their common corners. Of two
/// triangles with the same corners, and of two without area on the same edge, the answer is yes.
bool has_contact(std::span<const Vec3> points, const Simplex& a, const Simplex& b);

}  // namespace recede::detail
