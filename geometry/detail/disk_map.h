// The map of a disk whose border is known.
#pragma once

#include <recede/geometry/parameterization.h>

namespace recede::detail {

/// A disk by its triangles. Two vertices may share more than one edge, which indices alone don't tell.
struct Disk {
  std::vector<Vec3> positions;
  std::vector<Index> triangles;
  std::vector<Index> border;  ///< vertices of the border, counter-clockwise, at least three
};

/// As `parameterize_disk`, without its checks.
Parameterization map_disk(const Disk& disk, const ParameterizationOptions& options);

/// Sums over the triangles of a map from which its stretch follows.
class StretchSum {
 public:
  void add(const Vec3& a, const Vec3& b, const Vec3& c, const Vec2& p, const Vec2& q, const Vec2& r);
  Stretch stretch() const;
  /// Sum of areas times squared derivatives by the plane's coordinates: xx, xy, yy.
  const Eigen::Matrix2d& metric() const { return metric_; }

 private:
  double area_ = 0, plane_area_ = 0, largest_ = 0;
  bool infinite_ = false;
  Eigen::Matrix2d metric_ = Eigen::Matrix2d::Zero();
};

}  // namespace recede::detail
