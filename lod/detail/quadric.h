// Plane quadrics, kept relative to a centre so that they lose no digits far from the origin (Garland,
// Heckbert 1997).
#pragma once

#include <recede/geometry/vec.h>

#include <Eigen/Core>

namespace recede::detail {

/// x -> (x-c)' A (x-c) + 2 b'(x-c) + constant, where c is the centre that the owner knows: a weighted sum of
/// squared distances to planes (and lines). Symmetric A as xx, xy, xz, yy, yz, zz.
struct Quadric {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  Vec3 b = Vec3::Zero();
  double constant = 0;
  double weight = 0;  ///< sum of the planes' weights

  Eigen::Matrix3d matrix() const {
    Eigen::Matrix3d m;
    m << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    return m;
  }
  Vec3 times(const Vec3& x) const {
    return {xx * x.x() + xy * x.y() + xz * x.z(), xy * x.x() + yy * x.y() + yz * x.z(),
            xz * x.x() + yz * x.y() + zz * x.z()};
  }
  /// Value at `x`, given relative to the centre. Rounding must not make it negative.
  double operator()(const Vec3& x) const {
    const double value = x.dot(times(x)) + 2 * b.dot(x) + constant;
    return value > 0 ? value : 0;
  }
  /// Adds `w` times the squared distance to the plane of unit normal `n` through `point`, relative to the
  /// centre.
  void add_plane(const Vec3& n, const Vec3& point, double w) {
    const double d = -n.dot(point);
    xx += w * n.x() * n.x();
    xy += w * n.x() * n.y();
    xz += w * n.x() * n.z();
    yy += w * n.y() * n.y();
    yz += w * n.y() * n.z();
    zz += w * n.z() * n.z();
    b += w * d * n;
    constant += w * d * d;
    weight += w;
  }
  /// Adds a quadric whose centre stands at `offset` from this one's.
  void add(const Quadric& q, const Vec3& offset) {
    const Vec3 moved = q.times(offset);
    xx += q.xx;
    xy += q.xy;
    xz += q.xz;
    yy += q.yy;
    yz += q.yz;
    zz += q.zz;
    b += q.b - moved;
    constant += offset.dot(moved) - 2 * q.b.dot(offset) + q.constant;
    weight += q.weight;
  }
};

}  // namespace recede::detail
