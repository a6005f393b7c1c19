// Signs that decide how points of the plane are connected. They are never wrong, whatever the finite
// coordinates: a rounded value decides where its error can't matter, and whole numbers elsewhere.
//
// J. R. Shewchuk: Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates. Discrete
// & Computational Geometry 18, 1997: the bounds of the rounding errors.
#pragma once

#include <recede/geometry/vec.h>

#include <cmath>
#include <limits>

namespace recede::detail {

/// The signs by whole numbers: tens of times as slow.
int exact_orientation(const Vec2& a, const Vec2& b, const Vec2& c);
int exact_side_of_circle(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d);

inline constexpr double k_half_ulp = 0.5 * std::numeric_limits<double>::epsilon();

/// 1 when c lies to the left of the line from a to b, -1 to the right, 0 on it.
inline int orientation(const Vec2& a, const Vec2& b, const Vec2& c) {
  constexpr double k_error = 4 * k_half_ulp;  // a little more than 3 in the paper: the bound is a sum here
  // Above what products lose that are too small for a double.
  constexpr double k_underflow = std::numeric_limits<double>::min();
  const double left = (a.x() - c.x()) * (b.y() - c.y()), right = (a.y() - c.y()) * (b.x() - c.x());
  const double value = left - right, bound = k_error * (std::abs(left) + std::abs(right)) + k_underflow;
  // False for overflows as well, where the bound is infinite or the value no number.
  if (value > bound) return 1;
  if (value < -bound) return -1;
  return exact_orientation(a, b, c);
}

/// 1 when d lies inside the circle through a, b and c, which turn to the left, -1 outside, 0 on it.
inline int side_of_circle(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  constexpr double k_error = 11 * k_half_ulp;  // a little more than 10 in the paper
  // Products of two numbers may each lose 2^-1075; times a square of at most k_largest that is less.
  constexpr double k_largest = 1e150, k_underflow = 1e-160;
  const double ax = a.x() - d.x(), ay = a.y() - d.y();
  const double bx = b.x() - d.x(), by = b.y() - d.y();
  const double cx = c.x() - d.x(), cy = c.y() - d.y();
  const double bxcy = bx * cy, cxby = cx * by, a_square = ax * ax + ay * ay;
  const double cxay = cx * ay, axcy = ax * cy, b_square = bx * bx + by * by;
  const double axby = ax * by, bxay = bx * ay, c_square = cx * cx + cy * cy;
  const double value = a_square * (bxcy - cxby) + b_square * (cxay - axcy) + c_square * (axby - bxay);
  const double size = (std::abs(bxcy) + std::abs(cxby)) * a_square +
                      (std::abs(cxay) + std::abs(axcy)) * b_square +
                      (std::abs(axby) + std::abs(bxay)) * c_square;
  const double bound = k_error * size + k_underflow;
  if (a_square + b_square + c_square < k_largest) {
    if (value > bound) return 1;
    if (value < -bound) return -1;
  }
  return exact_side_of_circle(a, b, c, d);
}

}  // namespace recede::detail
