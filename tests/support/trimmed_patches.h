// Patches that tests put together by hand.
#pragma once

#include "nurbs_surfaces.h"
#include <recede/geometry/trimmed_patch.h>

namespace recede::test {

inline TrimmingCurve line(const Vec2& from, const Vec2& to) { return {{1, {0, 0, 1, 1}, {from, to}, {}}}; }

/// Once around the whole domain of a surface.
inline TrimmingLoop around_domain(const NurbsSurface& surface) {
  const ParameterRange u = surface.domain(0), v = surface.domain(1);
  const Vec2 a(u.begin, v.begin), b(u.end, v.begin), c(u.end, v.end), d(u.begin, v.end);
  return {{line(a, b), line(b, c), line(c, d), line(d, a)}};
}

inline TrimmedPatch whole(const NurbsSurface& surface, const std::string& name = "patch") {
  return {surface, {around_domain(surface)}, false, name};
}

/// A parallelogram with a corner and two sides.
inline NurbsSurface parallelogram(const Vec3& corner, const Vec3& side_u, const Vec3& side_v) {
  return {{1, 1},
          {std::vector<double>{0, 0, 1, 1}, {0, 0, 1, 1}},
          {corner, corner + side_v, corner + side_u, corner + side_u + side_v},
          {}};
}

/// The six faces of a box from the origin, each with its normal outwards, that know nothing of one another.
inline std::vector<TrimmedPatch> box_faces(const Vec3& size) {
  const Vec3 x(size.x(), 0, 0), y(0, size.y(), 0), z(0, 0, size.z()), o = Vec3::Zero();
  return {whole(parallelogram(o, y, x), "bottom"), whole(parallelogram(z, x, y), "top"),
          whole(parallelogram(o, x, z), "front"),  whole(parallelogram(y, z, x), "back"),
          whole(parallelogram(o, z, y), "left"),   whole(parallelogram(x, y, z), "right")};
}

/// A circle in a plane of parameters, counter-clockwise, or clockwise as holes are.
inline TrimmingLoop circle(const Vec2& center, double radius, bool is_hole) {
  NurbsCurve2 curve = unit_circle();
  for (Vec2& point : curve.points) point = center + radius * point;
  return {{{is_hole ? reversed(curve) : curve}}};
}

/// A closed can around z: its wall, which closes on itself, a bottom and a top.
inline std::vector<TrimmedPatch> can(double radius, double height) {
  NurbsSurface wall{{2, 1}, {unit_circle().knots, {0, 0, 1, 1}}, {}, {}};
  for (std::size_t i = 0; i < 9; ++i) {
    for (const double z : {0.0, height}) {
      wall.points.emplace_back(radius * unit_circle().points[i].x(), radius * unit_circle().points[i].y(), z);
      wall.weights.push_back(unit_circle().weights[i]);
    }
  }
  const Vec3 corner(-2 * radius, -2 * radius, 0), x(4 * radius, 0, 0), y(0, 4 * radius, 0);
  TrimmedPatch top{
      parallelogram(corner + Vec3(0, 0, height), x, y), {circle({0.5, 0.5}, 0.25, false)}, false, "top"};
  TrimmedPatch bottom{parallelogram(corner, y, x), {circle({0.5, 0.5}, 0.25, false)}, false, "bottom"};
  return {whole(wall, "wall"), bottom, top};
}

}  // namespace recede::test
