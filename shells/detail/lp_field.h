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

/// Sums over the surface, in the frame. Powers p of lengths come relative to a length near the distance.
struct LpSums {
  double integral = 0;  ///< I_p
  Vec3 gradient = Vec3::Zero();
  double area = 0;            ///< that was integrated, by weights
  double error = 0;           ///< of the integral, at most
  double gradient_error = 0;  ///< at most
};

class LpField {
 public:
  LpField(const PolygonSoup& surface, const LpDistanceOptions& options);
  LpValue at(const Vec3& point) const;
  double area() const { return area_; }

 private:
  struct Query;
  template <bool is_cubic, bool is_weighted, bool is_bounded>
  LpSums integrate(const Query& query) const;
  LpSums sum_up(const Query& query) const;
  template <bool is_cubic, bool is_weighted>
  void add_triangles(const Query& query, std::size_t block, LpSums& sums) const;
  template <bool is_weighted>
  void add_points(const Query& query, std::size_t block, LpSums& sums) const;
  LpValue value_of(const LpSums& sums, double unit) const;

  LpDistanceOptions options_;
  LpFrame frame_;
  double area_ = 0;     // object units
  double support_ = 0;  // in the frame
  LpTree tree_;
  std::unique_ptr<const ClosestPointTree> nearest_;  // unless p = 3
};

}  // namespace recede::detail
