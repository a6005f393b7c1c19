// Where a surface is on the whole, and how it is spread.
#pragma once

#include <recede/geometry/vec.h>

namespace recede::detail {

/// Integrals over a surface of triangles. They add up.
struct SurfaceMoments {
  double area = 0;
  Vec3 first = Vec3::Zero();                         ///< of positions
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  ///< of their products
  Vec3 normal = Vec3::Zero();                        ///< of unit normals

  void add(const Vec3& a, const Vec3& b, const Vec3& c);
  SurfaceMoments& operator+=(const SurfaceMoments& other);

  /// Unit axes as columns, along which the surface is spread: the narrowest first.
  Eigen::Matrix3d axes() const;
};

}  // namespace recede::detail
