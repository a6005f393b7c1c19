#include <recede/lod/detail/surface_moments.h>

#include <array>
#include <cmath>

namespace recede::detail {

namespace {

// Unit eigenvectors of a symmetric matrix, and its eigenvalues, rising.
struct EigenAxes {
  std::array<Vec3, 3> vectors{Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  Vec3 values = Vec3::Zero();
};

// The eigenvalue farthest from the two others by Newton's method from beyond it, then a plane is left.
EigenAxes eigen_axes_of(const Eigen::Matrix3d& matrix) {
  EigenAxes result;
  const double mean = matrix.trace() / 3;
  result.values.setConstant(mean);
  Eigen::Matrix3d rest = matrix;
  rest.diagonal().array() -= mean;
  const double scale = rest.cwiseAbs().maxCoeff();
  if (!(scale > 0)) return result;
  rest /= scale;
  // x^3 - a x - b has these roots, of which the one with the sign of b is simple.
  const double a = rest.squaredNorm() / 2, b = rest.determinant(), sign = b < 0 ? -1 : 1;
  double root = 2 * std::sqrt(a / 3);
  constexpr int k_steps = 5;  // from at most 1.16 times the root; each doubles the digits
  for (int step = 0; step < k_steps; ++step)
    root -= (root * (root * root - a) - sign * b) / (3 * root * root - a);
  root *= sign;
  Eigen::Matrix3d shifted = rest;
  shifted.diagonal().array() -= root;
  Vec3 alone = Vec3::Zero();
  for (int row = 0; row < 3; ++row) {
    const Vec3 cross = shifted.col(row).cross(shifted.col((row + 1) % 3));
    if (cross.squaredNorm() > alone.squaredNorm()) alone = cross;
  }
  alone.normalize();
  const Vec3 u = alone.unitOrthogonal(), v = alone.cross(u);
  const Vec3 of_u = rest * u, of_v = rest * v;
  const double half = (u.dot(of_u) - v.dot(of_v)) / 2, mixed = u.dot(of_v),
               reach = std::sqrt(half * half + mixed * mixed), middle = (u.dot(of_u) + v.dot(of_v)) / 2;
  Vec2 larger = half < 0 ? Vec2(mixed, reach - half) : Vec2(half + reach, mixed);
  larger = reach > 0 ? Vec2(larger.normalized()) : Vec2::UnitX();
  const Vec3 low = larger.x() * v - larger.y() * u, high = larger.x() * u + larger.y() * v;
  if (sign > 0) {
    result.vectors = {low, high, alone};
    result.values = mean * Vec3::Ones() + scale * Vec3(middle - reach, middle + reach, root);
  } else {
    result.vectors = {alone, low, high};
    result.values = mean * Vec3::Ones() + scale * Vec3(root, middle - reach, middle + reach);
  }
  return result;
}

}  // namespace

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
  const EigenAxes eigen = eigen_axes_of(spread);
  const Vec3& values = eigen.values;
  Vec3 narrow = eigen.vectors[0];
  const Vec3& wide = eigen.vectors[2];
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
