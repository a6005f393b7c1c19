// The signs of volumes that decide on which side of a plane a point of space lies. They are never wrong,
// whatever the finite coordinates: a rounded value decides where its error can't matter, and whole numbers
// elsewhere.
//
// J. R. Shewchuk: Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates. Discrete
// & Computational Geometry 18, 1997: the way in which rounding errors are counted.
#pragma once

#include <recede/geometry/vec.h>

#include <cmath>
#include <limits>

namespace recede::detail {

/// A rounded value and how far from the true one it can be; both are infinite or no numbers after overflows.
struct RoundedValue {
  double value = 0;
  double error = 0;

  /// 1 or -1 where the error can't change the sign, otherwise 0.
  int sign() const { return value > error ? 1 : value < -error ? -1 : 0; }
};

/// The determinant of b - a, c - a and d - a: six times the volume of their tetrahedron.
inline RoundedValue rounded_determinant(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  // Two roundings of differences, one of a product and one of the inner difference; then those of a
  // difference, a product and two sums: eight, and a little more, for the bound is rounded as well.
  constexpr double k_error = 10 * (0.5 * std::numeric_limits<double>::epsilon());
  // Above what products lose that are too small for a double: 2^-1075 for each, times the third factor.
  constexpr double k_underflow = std::numeric_limits<double>::min();
  const double ux = b.x() - a.x(), uy = b.y() - a.y(), uz = b.z() - a.z();
  const double vx = c.x() - a.x(), vy = c.y() - a.y(), vz = c.z() - a.z();
  const double wx = d.x() - a.x(), wy = d.y() - a.y(), wz = d.z() - a.z();
  const double vywz = vy * wz, vzwy = vz * wy, vzwx = vz * wx, vxwz = vx * wz, vxwy = vx * wy, vywx = vy * wx;
  const double value = ux * (vywz - vzwy) + uy * (vzwx - vxwz) + uz * (vxwy - vywx);
  const double size = std::abs(ux) * (std::abs(vywz) + std::abs(vzwy)) +
                      std::abs(uy) * (std::abs(vzwx) + std::abs(vxwz)) +
                      std::abs(uz) * (std::abs(vxwy) + std::abs(vywx));
  return {value, k_error * size + k_underflow * (1 + std::abs(ux) + std::abs(uy) + std::abs(uz))};
}

/// The sign by whole numbers: tens of times as slow.
int exact_side_of_plane(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// 1 when d lies on the side of the plane through a, b and c from which they turn to the left, -1 on the
/// other side, 0 on the plane, and also when a, b and c lie on one line.
inline int side_of_plane(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const int sign = rounded_determinant(a, b, c, d).sign();
  return sign != 0 ? sign : exact_side_of_plane(a, b, c, d);
}

}  // namespace recede::detail
