// Surfaces whose averaged distances are known, and integrals over triangles by other means.
#pragma once

#include "simple_soups.h"
#include <recede/shells/lp_distance.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace recede::test {

inline constexpr double k_pi = std::numbers::pi;

/// Without summing up: exact up to rounding.
inline LpDistanceOptions exact(double p = 3, LpForm form = LpForm::calibrated) {
  return {.p = p, .form = form, .opening = std::numeric_limits<double>::infinity()};
}

inline PolygonSoup one_triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
  PolygonSoup soup;
  soup.positions = {a, b, c};
  soup.add_face(std::array<Index, 3>{0, 1, 2});
  return soup;
}

/// Adds a parallelogram.
inline void add_sheet(PolygonSoup& soup, const Vec3& corner, const Vec3& u, const Vec3& v) {
  const auto first = static_cast<Index>(soup.positions.size());
  soup.positions.insert(soup.positions.end(), {corner, corner + u, corner + u + v, corner + v});
  soup.add_face(std::array<Index, 4>{first, first + 1, first + 2, first + 3});
}

/// A square of `half` on either side of the axis at height `z`.
inline PolygonSoup square(double half, double z = 0) {
  PolygonSoup soup;
  add_sheet(soup, Vec3(-half, -half, z), Vec3(2 * half, 0, 0), Vec3(0, 2 * half, 0));
  return soup;
}

/// Two sheets of length `size` that meet at the z axis under an angle, the x axis between them.
inline PolygonSoup dihedral(double angle, double size) {
  PolygonSoup soup;
  for (const double side : {-1.0, 1.0}) {
    const Vec3 away(std::cos(0.5 * angle), side * std::sin(0.5 * angle), 0);
    add_sheet(soup, Vec3(0, 0, -size), size * away, Vec3(0, 0, 2 * size));
  }
  return soup;
}

/// `octahedral_sphere` without the triangles of which `may_stay` says so, by their centroids on the sphere.
template <typename MayStay>
PolygonSoup part_of_sphere(int levels, MayStay&& may_stay) {
  const PolygonSoup whole = octahedral_sphere(levels);
  PolygonSoup part;
  part.positions = whole.positions;
  for (std::size_t f = 0; f < whole.n_faces(); ++f) {
    Vec3 sum = Vec3::Zero();
    for (const Index v : whole.face(f)) sum += whole.positions[v];
    if (may_stay(Vec3(sum.normalized()))) part.add_face(whole.face(f));
  }
  return part;
}

inline PolygonSoup sphere(int levels) { return octahedral_sphere(levels); }

/// An ellipsoid with bumps of 8 * 4^levels triangles, about 2.6 units long.
inline PolygonSoup bumpy_ellipsoid(int levels) {
  PolygonSoup soup = sphere(levels);
  for (Vec3& p : soup.positions) {
    const double relief =
        1 + 0.1 * std::sin(5 * p.x() + 1) * std::sin(4 * p.y()) + 0.05 * std::sin(9 * p.z() + 2 * p.x());
    p = relief * Vec3(1.2 * p.x(), p.y(), 0.8 * p.z());
  }
  return soup;
}

inline PolygonSoup moved(PolygonSoup soup, double scale, const Eigen::Matrix3d& turn, const Vec3& by) {
  for (Vec3& p : soup.positions) p = scale * (turn * p) + by;
  return soup;
}

/// I_3 and its gradient, from what the calibrated distance says.
struct CubicIntegral {
  double value;
  Vec3 gradient;
};
inline CubicIntegral cubic_integral(const LpValue& value) {
  const double integral = 2 * k_pi / value.distance;
  return {integral, -integral / value.distance * value.gradient};
}

}  // namespace recede::test
