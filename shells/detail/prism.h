// The sign of the Jacobian in a prism between two triangles.
#pragma once

#include <recede/geometry/vec.h>

#include <array>

namespace recede::detail {

/// Three corners below and three above.
struct Prism {
  std::array<Vec3, 3> bottom, top;
};

/// Whether the Jacobian of x(l, r) = sum of l_i ((1 - r) bottom_i + r top_i) is above 0 in the whole prism
/// (below 0 with `is_inward`). Never wrong, whatever the finite coordinates.
///
/// The Jacobian is the sum of l_i q_i(r), where q_i(r) is the determinant of the sides at height r and the
/// step from bottom_i to top_i, so that the three quadratic polynomials q_i decide.
bool has_one_orientation(const Prism& prism, bool is_inward);

}  // namespace recede::detail
