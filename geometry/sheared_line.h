// A line prepared for watertight tests: against boxes, and against surfaces whose corners it shears so that
// the line becomes the third axis (Woop, Benthin and Wald 2013, "Watertight ray/triangle intersection").
#pragma once

#include <recede/geometry/vec.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace recede {

/// The line origin + t direction. What is computed of a point depends on that point alone, so neighbours that
/// share a point agree on it. Call it in sources that are compiled without contraction only.
class ShearedLine {
 public:
  /// `direction` has any length but 0.
  ShearedLine(const Vec3& origin, const Vec3& direction) : origin_(origin), direction_(direction) {
    direction.cwiseAbs().maxCoeff(&z_);
    x_ = (z_ + 1) % 3;
    y_ = (z_ + 2) % 3;
    if (direction[z_] < 0) std::swap(x_, y_);  // keeps the sense of rotation
    shear_x_ = direction[x_] / direction[z_];
    shear_y_ = direction[y_] / direction[z_];
    scale_ = 1 / direction[z_];
    inverse_ = direction.cwiseInverse();
  }

  const Vec3& origin() const { return origin_; }
  const Vec3& direction() const { return direction_; }

  /// The point in coordinates in which the line is x = y = 0 and z is t.
  Vec3 sheared(const Vec3& point) const {
    const Vec3 p = point - origin_;
    return {p[x_] - shear_x_ * p[z_], p[y_] - shear_y_ * p[z_], scale_ * p[z_]};
  }

  /// The part of the line in a box: t from `enter` to `leave`, none when enter > leave.
  struct Range {
    double enter = 0, leave = 0;
    bool empty() const { return enter > leave; }
  };
  /// That part of `within` that lies in the box, or between two planes across an axis; borders included.
  /// Rounding only makes it longer.
  Range clip_to_box(const Vec3& lower, const Vec3& upper, Range within) const {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      within = clip_to_slab(axis, lower[axis], upper[axis], within);
    }
    return within;
  }
  Range clip_to_slab(Eigen::Index axis, double lower, double upper, const Range& within) const {
    constexpr double k_rounding = 1e-15;  // three roundings of 1.1e-16 each, and to spare
    if (direction_[axis] == 0) {
      if (origin_[axis] < lower || origin_[axis] > upper) return {1, 0};
      return within;
    }
    const double a = (lower - origin_[axis]) * inverse_[axis];
    const double b = (upper - origin_[axis]) * inverse_[axis];
    const double low = std::min(a, b), high = std::max(a, b);
    return {std::max(within.enter, low * (low > 0 ? 1 - k_rounding : 1 + k_rounding)),
            std::min(within.leave, high * (high > 0 ? 1 + k_rounding : 1 - k_rounding))};
  }

 private:
  Vec3 origin_, direction_, inverse_;
  Eigen::Index x_ = 0, y_ = 1, z_ = 2;
  double shear_x_ = 0, shear_y_ = 0, scale_ = 1;
};

}  // namespace recede
