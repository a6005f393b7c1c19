#include <recede/lod/detail/surface_moments.h>

#include <Eigen/Eigenvalues>

namespace recede::detail {

void SurfaceMoments::add(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 cross = (b - a).cross(c - a), middle = (a + b + c) / 3;
  const double here = cross.norm() / 2;
  area += here;
  normal += cross / 2;
  first += here * middle;
  second += here / 12 *
            (a * a.transpose() + b * b.transpose() + c * c.transpose() + 9 * middle * middle.transpose());
}

SurfaceMoments& SurfaceMoments::operator+=(const SurfaceMoments& other) {
  area += other.area;
  first += other.first;
  second += other.second;
  normal += other.normal;
  return *this;
}

Eigen::Matrix3d SurfaceMoments::axes() const {
  const Vec3 mean = first / area;
  const Eigen::Matrix3d spread = second / area - mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(spread);
  const Vec3& values = solver.eigenvalues();
  Vec3 narrow = solver.eigenvectors().col(0);
  const Vec3 wide = solver.eigenvectors().col(2);
  // As narrow along two axes, as a rod is: which one comes first is chance, and normals know better.
  constexpr double k_alike = 0.01;
  if (values[1] - values[0] < k_alike * values[1] && normal.norm() > 0.5 * area) narrow = normal;
  narrow.normalize();
  Vec3 between = wide.cross(narrow);
  if (!(between.norm() > 0.1)) between = narrow.unitOrthogonal();
  between.normalize();
  Eigen::Matrix3d axes;
  axes << narrow, between, narrow.cross(between);
  return axes;
}

}  // namespace recede::detail
