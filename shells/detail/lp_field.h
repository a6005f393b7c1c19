// The integrals behind an Lp-averaged distance.
#pragma once

#include <recede/shells/detail/lp_tree.h>
#include <recede/shells/lp_distance.h>

namespace recede::detail {

/// Where the surface is kept: its box's middle in the origin and the larger extent about 1, by a power of two
/// that rounds nothing, so that high powers of distances neither overflow nor vanish.
struct LpFrame {
  explicit LpFrame(const Box3& box);
  Vec3 inside(const Vec3& p) const;
  double outside(double length) const;

  Vec3 center = Vec3::Zero();
  int exponent = 0;
};

class LpField {
 public:
  LpField(const PolygonSoup& surface, const LpDistanceOptions& options);
  LpValue at(const Vec3& point) const;
  /// At points of which the next is near: faster, within a support many times, and up to rounding the same.
  /// The values don't depend on which points are asked for together.
  void at_each(std::span<const Vec3> points, std::span<LpValue> values) const;
  double area() const { return area_; }

 private:
  LpQuery query_of(const Vec3& point) const;
  LpValue value_of(const LpSums& sums, double unit) const;

  LpDistanceOptions options_;
  LpFrame frame_;
  double area_ = 0;     // object units
  double mass_ = 0;     // the same in the frame
  double support_ = 0;  // in the frame
  LpTree tree_;
  bool is_together_ = false;                         // whether points are summed up together
  std::vector<LpFade> fades_;                        // of the tree's nodes, where packets are summed up
  std::unique_ptr<const ClosestPointTree> nearest_;  // unless p = 3
};

}  // namespace recede::detail
