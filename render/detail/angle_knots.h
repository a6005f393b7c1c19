// Directions by angles, and where these lie between the knots of a table.
#pragma once

#include <recede/geometry/vec.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace recede::detail {

inline Vec3 direction_of(double angle, double azimuth) {
  return {std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth), std::cos(angle)};
}

inline double azimuth_of(const Vec3& direction) {
  return direction.x() == 0 && direction.y() == 0 ? 0.0 : std::atan2(direction.y(), direction.x());
}

inline double polar_angle_of(const Vec3& direction) {
  return std::atan2(std::hypot(direction.x(), direction.y()), direction.z());
}

/// A place on an axis of knots: the one before, the one after, and where in between.
struct KnotPlace {
  std::size_t before = 0, after = 0;
  double fraction = 0;
};

/// Knots evenly from 0 to 90 degrees, both included.
inline KnotPlace place_of_angle(double angle, int knots) {
  const double steps = std::clamp(angle / (std::numbers::pi / 2) * (knots - 1), 0.0, knots - 1.0);
  const int before = std::min(static_cast<int>(steps), knots - 2);
  return {static_cast<std::size_t>(before), static_cast<std::size_t>(before + 1), steps - before};
}

/// Knots evenly around the circle, the first at 0.
inline KnotPlace place_of_azimuth(double azimuth, int knots) {
  double steps = azimuth / (2 * std::numbers::pi);
  steps = std::isfinite(steps) ? (steps - std::floor(steps)) * knots : 0.0;
  const int before = std::min(static_cast<int>(steps), knots - 1);
  return {static_cast<std::size_t>(before), static_cast<std::size_t>((before + 1) % knots),
          std::min(steps - before, 1.0)};
}

}  // namespace recede::detail
