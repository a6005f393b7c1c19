// Surfaces whose averaged distances are known, and integrals over triangles by other means.
#pragma once

#include <recede/shells/lp_distance.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>
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

/// The unit sphere: an octahedron whose triangles are cut in four `levels` times, 8 * 4^levels of them,
/// turned outward. `may_stay` says of a centroid whether the triangle is there.
template <typename MayStay>
PolygonSoup part_of_sphere(int levels, MayStay&& may_stay) {
  std::vector<Vec3> positions = {Vec3::UnitX(),  Vec3::UnitY(),  Vec3::UnitZ(),
                                 -Vec3::UnitX(), -Vec3::UnitY(), -Vec3::UnitZ()};
  std::vector<std::array<Index, 3>> triangles = {{0, 1, 2}, {1, 3, 2}, {3, 4, 2}, {4, 0, 2},
                                                 {1, 0, 5}, {3, 1, 5}, {4, 3, 5}, {0, 4, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<Index, Index>, Index> middles;
    const auto middle = [&](Index a, Index b) {
      const auto [entry, is_new] =
          middles.try_emplace(std::minmax(a, b), static_cast<Index>(positions.size()));
      if (is_new) positions.push_back(Vec3(positions[a] + positions[b]).normalized());
      return entry->second;
    };
    std::vector<std::array<Index, 3>> finer;
    for (const auto& [a, b, c] : triangles) {
      const Index ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    triangles = std::move(finer);
  }
  PolygonSoup soup;
  soup.positions = std::move(positions);
  for (const auto& t : triangles) {
    if (may_stay(Vec3((soup.positions[t[0]] + soup.positions[t[1]] + soup.positions[t[2]]).normalized())))
      soup.add_face(t);
  }
  return soup;
}

inline PolygonSoup sphere(int levels) {
  return part_of_sphere(levels, [](const Vec3&) { return true; });
}

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
