#include "experiment_shapes.h"

#include "shell_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace recede::bench {
namespace {

constexpr double k_pi = std::numbers::pi;

/// Radii of a ball times what `scale` says of directions.
PolygonSoup star(int n, double (*scale)(const Vec3&)) {
  PolygonSoup body = test::ball(n);
  for (Vec3& p : body.positions) p *= scale(p);
  return body;
}

double spikes_at(const Vec3& direction) {
  constexpr double k_golden = std::numbers::phi;
  double spike = 0, notch = 0;
  const auto along = [&](const Vec3& axis) {
    return std::acos(std::min(1.0, direction.dot(axis.normalized())));
  };
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-1.0, 1.0}) {
      for (int axis = 0; axis < 3; ++axis) {
        Vec3 corner = Vec3::Zero(), other = Vec3::Zero();
        corner[axis] = a;
        corner[(axis + 1) % 3] = b * k_golden;
        other[axis] = a / k_golden;
        other[(axis + 1) % 3] = b * k_golden;
        spike = std::max(spike, 1 - along(corner) / 0.3);
        notch = std::max(notch, 1 - along(other) / 0.2);
      }
      for (const double c : {-1.0, 1.0}) notch = std::max(notch, 1 - along({a, b, c}) / 0.2);
    }
  }
  return 1 + 0.8 * spike - 0.4 * notch;
}

double ears_at(const Vec3& direction) {
  double ear = 0;
  for (const double side : {-1.0, 1.0}) {
    const Vec3 axis = Vec3(0, side, 1.2).normalized(), across = Vec3::UnitX(), along = axis.cross(across);
    if (direction.dot(axis) <= 0) continue;
    const double u = std::atan2(direction.dot(across), direction.dot(axis)) / 0.06,
                 v = std::atan2(direction.dot(along), direction.dot(axis)) / 0.25;
    ear = std::max(ear, std::exp(-u * u - v * v));
  }
  return 1 + ear;
}

}  // namespace

PolygonSoup bent_strip(double turning, double radius) {
  return test::sheet(k_strip_sides, k_strip_rows, [&](double u, double v) {
    // Arc length from the middle: an arc, and straight beyond it.
    const double s = (2 * u - 1) * 2, half = radius * turning / 2, on_arc = std::clamp(s, -half, half),
                 straight = s - on_arc,
                 angle = radius > 0 ? on_arc / radius : (s < 0 ? -turning / 2 : turning / 2);
    const double x = (radius > 0 ? radius * std::sin(angle) : 0) + straight * std::cos(angle),
                 z = (radius > 0 ? radius * (1 - std::cos(angle)) : 0) + straight * std::sin(angle);
    return Vec3(x, 4 * v - 2, z);
  });
}

PolygonSoup spiky_ball(int n) { return star(n, spikes_at); }

PolygonSoup eared_ball(int n) { return star(n, ears_at); }

PolygonSoup hook() {
  constexpr double k_tube = 0.25, k_turn = 2 * k_pi * 5 / 6;
  constexpr int k_around = 16, k_along = 80, k_cap = 4;
  constexpr int k_rows = k_along + 2 * k_cap;
  PolygonSoup body = test::sheet(k_around, k_rows, [&](double u, double v) {
    const double row = std::round(v * k_rows), around = -2 * k_pi * std::fmod(u, 1.0),
                 along = std::clamp(row - k_cap, 0.0, static_cast<double>(k_along)),
                 // On caps, how far from the last circle towards the pole.
        beyond = (row - k_cap - along) / k_cap * k_pi / 2;
    const double turn = k_turn * along / k_along,
                 radius = std::abs(beyond) >= k_pi / 2 - 1e-12 ? 0 : k_tube * std::cos(beyond);
    const Vec3 out(std::cos(turn), std::sin(turn), 0), ahead(-std::sin(turn), std::cos(turn), 0);
    return Vec3(out + radius * (std::cos(around) * out + std::sin(around) * Vec3::UnitZ()) +
                k_tube * std::sin(beyond) * ahead);
  });
  merge_identical_vertices(body);
  // The poles' triangles without area.
  PolygonSoup clean;
  clean.positions = body.positions;
  for (std::size_t f = 0; f < body.n_faces(); ++f) {
    const auto corners = body.face(f);
    if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0])
      clean.add_face(corners);
  }
  return clean;
}

PolygonSoup notch_and_arms() {
  const std::vector<Vec2> corners{{-2.2, 0},
                                  {-1, 0},
                                  {-1, 1.5},
                                  {-k_notch_gap / 2, 1.5},
                                  {-k_notch_gap / 2, 0.3},
                                  {0, -0.6},
                                  {k_notch_gap / 2, 0.3},
                                  {k_notch_gap / 2, 1.5},
                                  {1, 1.5},
                                  {1, 0},
                                  {2.2, 0}};
  std::vector<Vec2> profile;
  for (std::size_t c = 0; c + 1 < corners.size(); ++c) {
    const int parts = static_cast<int>(std::ceil((corners[c + 1] - corners[c]).norm() / 0.1));
    for (int i = 0; i < parts; ++i)
      profile.push_back(corners[c] + static_cast<double>(i) / parts * (corners[c + 1] - corners[c]));
  }
  profile.push_back(corners.back());
  const int n = static_cast<int>(profile.size()) - 1, rows = static_cast<int>(k_notch_rows) - 1;
  return test::sheet(n, rows, [&](double u, double v) {
    const Vec2& at = profile[static_cast<std::size_t>(std::round(u * n))];
    return Vec3(at.x(), 0.8 * v - 0.4, at.y());
  });
}

}  // namespace recede::bench
