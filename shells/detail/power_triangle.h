// The integral of |y|^-p over a triangle and its gradient, by quadrature along the edges, for any p above 1.
#pragma once

#include <recede/geometry/vec.h>

namespace recede::detail {

struct TriangleIntegral {
  double value = 0;
  Vec3 gradient = Vec3::Zero();  ///< by the point of interest, which is the origin
};

/// `a`, `b`, `c` relative to the point of interest, `normal` the unit normal of that order. To about 1e-10,
/// relative, for p up to 64 and distances of up to ten times the triangle's size; farther away digits are
/// lost with the square of the distance over the size. Infinite on the triangle for p of 2 and more.
TriangleIntegral integrate_power(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& normal, double p);

}  // namespace recede::detail
