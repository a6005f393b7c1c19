// Views for tests of dicing, and where they show a point.
#pragma once

#include <recede/geometry/displacement_map.h>
#include <recede/lod/view_dependent_remesh.h>

#include <cmath>

namespace recede::test {

inline RemeshView view_from(const Vec3& position, int size = 120, const Vec3& target = Vec3::Zero()) {
  RemeshView view;
  view.position = position;
  view.target = target;
  view.width = view.height = size;
  return view;
}

/// Where a point is seen, pixels from the upper left corner, and how deep. By its own formula.
inline Vec3 on_screen(const RemeshView& view, const Vec3& point) {
  const Vec3 forward = (view.target - view.position).normalized(),
             right = forward.cross(view.up).normalized();
  const Vec3 up = right.cross(forward), p = point - view.position;
  const double depth = p.dot(forward), pixels = view.height / (2 * std::tan(view.field_of_view / 2)) / depth;
  return {0.5 * view.width + pixels * p.dot(right), 0.5 * view.height - pixels * p.dot(up), depth};
}

/// A map of one height.
inline DisplacementMap level_map(float height = 0) { return {1, 1, {height}}; }

}  // namespace recede::test
