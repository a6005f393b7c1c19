// Numbers and vectors of which only limits are known. Rounding isn't directed: results are good to a few
// units in the last place, which users of bounds add.
#pragma once

#include <recede/geometry/vec.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede::detail {

/// In single precision, but not below (or above) the number. None stays none.
inline float rounded_up(double value) {
  if (value == 0) return 0;
  return std::nextafter(static_cast<float>(value), std::numeric_limits<float>::infinity());
}
inline float rounded_down(double value) { return -rounded_up(-value); }

struct RealInterval {
  double lower, upper;
};

inline RealInterval operator*(const RealInterval& a, const RealInterval& b) {
  const double ll = a.lower * b.lower, lu = a.lower * b.upper, ul = a.upper * b.lower, uu = a.upper * b.upper;
  return {std::min({ll, lu, ul, uu}), std::max({ll, lu, ul, uu})};
}

inline RealInterval operator-(const RealInterval& a, const RealInterval& b) {
  return {a.lower - b.upper, a.upper - b.lower};
}

/// A box of vectors.
struct IntervalVec3 {
  Vec3 lower = Vec3::Constant(1e300), upper = Vec3::Constant(-1e300);

  void extend(const Vec3& point) {
    lower = lower.cwiseMin(point);
    upper = upper.cwiseMax(point);
  }
  RealInterval operator[](int axis) const { return {lower[axis], upper[axis]}; }
  void set(int axis, const RealInterval& value) {
    lower[axis] = value.lower;
    upper[axis] = value.upper;
  }
  /// Of the longest vector.
  double length() const { return lower.cwiseAbs().cwiseMax(upper.cwiseAbs()).norm(); }
};

inline IntervalVec3 operator-(const IntervalVec3& a, const IntervalVec3& b) {
  return {a.lower - b.upper, a.upper - b.lower};
}

inline IntervalVec3 operator*(const RealInterval& a, const IntervalVec3& b) {
  IntervalVec3 result;
  for (int axis = 0; axis < 3; ++axis) result.set(axis, a * b[axis]);
  return result;
}

inline IntervalVec3 cross(const IntervalVec3& a, const IntervalVec3& b) {
  IntervalVec3 result;
  for (int axis = 0; axis < 3; ++axis) {
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    result.set(axis, a[next] * b[last] - a[last] * b[next]);
  }
  return result;
}

}  // namespace recede::detail
