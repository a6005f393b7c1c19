// Light on a displaced plane by paths of rays: what tables of its reflectance are compared with.
#pragma once

#include "displaced_planes.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace recede::test {

/// Means by how often light has met the surface, for albedo 1 and as `ScatteringTable` has them.
struct TracedLight {
  static constexpr std::size_t k_orders = 12;
  std::array<double, k_orders> orders{};

  double sum(double albedo) const {
    double sum = 0;
    for (std::size_t k = 0; k < k_orders; ++k)
      sum += std::pow(albedo, static_cast<double>(k + 1)) * orders[k];
    return sum;
  }
};

/// From a viewer at an angle, over all azimuths unless one is given, with parallel light at an angle and at
/// an azimuth counted from the viewer's. Paths are followed to the sky or for as many places as there are
/// orders.
inline TracedLight trace_light(const DisplacedPlane& plane, double view_angle, double light_angle,
                               double light_azimuth, int count, std::optional<double> fixed_azimuth = {}) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(0, 1);
  TracedLight light;
  const double raised = 1e-7 * plane.sides().minCoeff();
  for_places(plane, count, [&](const Vec2& place, double azimuth) {
    if (fixed_azimuth) azimuth = *fixed_azimuth;
    const Vec3 toward_light = direction_at(light_angle, azimuth + light_azimuth);
    Vec3 direction = -direction_at(view_angle, azimuth);
    Vec3 start = Vec3(place.x(), place.y(), plane.heights().max) - 0.01 * direction;
    for (double& order : light.orders) {
      const auto hit = plane.first_hit(start, direction);
      if (!hit) return;
      start += hit->t * direction + raised * Vec3::UnitZ();
      const double facing = hit->normal.dot(toward_light);
      if (facing > 0 && !plane.first_hit(start, toward_light)) order += facing / count;
      const double x = number(random), level = std::sqrt(x), turn = 2 * std::numbers::pi * number(random);
      const Vec3 across = hit->normal.unitOrthogonal(), aside = hit->normal.cross(across);
      direction =
          level * std::cos(turn) * across + level * std::sin(turn) * aside + std::sqrt(1 - x) * hit->normal;
    }
  });
  return light;
}

/// Facets of 45 degrees that fall and rise along u; the valley is at u = 0, the ridge at 1/2, both between
/// cells. On a plane of sides of 1.
inline DisplacementMap groove(int size) {
  return map_of(size, [&](double u, double) { return 0.5 - std::abs(u - 0.5 / size - 0.5); });
}

}  // namespace recede::test
