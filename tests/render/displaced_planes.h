// Height maps for tests of appearance, and measurements of what is seen of them that don't use its tables.
#pragma once

#include <recede/render/displaced_plane.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

namespace recede::test {

/// A periodic map of `size` x `size` heights from a function of u and v.
template <class Function>
DisplacementMap map_of(int size, const Function& height) {
  std::vector<float> heights;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x)
      heights.push_back(static_cast<float>(height((x + 0.5) / size, 1 - (y + 0.5) / size)));
  }
  return {size, size, std::move(heights), MapBorder::periodic};
}

/// Forty waves of random direction and phase, up to four to a side; the highest place is `peak` above the
/// mean. `stretch` makes those along v longer: 1 is isotropic.
inline DisplacementMap random_waves(unsigned seed, double peak, int size = 32, int stretch = 1) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> along_u(-4, 4), along_v(-4 / stretch, 4 / stretch);
  std::uniform_real_distribution<double> number(0, 1);
  struct Wave {
    int u, v;
    double phase, amplitude;
  };
  std::vector<Wave> waves;
  while (waves.size() < 40) {
    const Wave wave{along_u(random), along_v(random), 2 * std::numbers::pi * number(random), number(random)};
    if (wave.u != 0 || wave.v != 0) waves.push_back(wave);
  }
  const auto sum = [&](double u, double v) {
    double height = 0;
    for (const Wave& w : waves)
      height += w.amplitude * std::cos(2 * std::numbers::pi * (w.u * u + w.v * v) + w.phase);
    return height;
  };
  double most = 0;
  for (int i = 0; i < size * size; ++i)
    most = std::max(most, sum((i % size + 0.5) / size, (i / size + 0.5) / size));
  return map_of(size, [&](double u, double v) { return peak / most * sum(u, v); });
}

/// Independent heights from 0 to `height` in every texel.
inline DisplacementMap rough_ground(unsigned seed, double height, int size = 24) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(0, height);
  return map_of(size, [&](double, double) { return number(random); });
}

/// Half-spheres on a plane, 3 x 3 of them in a map: kinks, and places that are flat.
inline DisplacementMap round_bumps(double height) {
  return map_of(48, [&](double u, double v) {
    const double x = 2 * (3 * u - std::floor(3 * u)) - 1, y = 2 * (3 * v - std::floor(3 * v)) - 1;
    return height * std::sqrt(std::max(0.0, 0.81 - x * x - y * y));
  });
}

/// A vector in the frame of a viewer at an azimuth, or back from there.
inline Vec3 turned(const Vec3& v, double azimuth) {
  const double c = std::cos(azimuth), s = std::sin(azimuth);
  return {c * v.x() - s * v.y(), s * v.x() + c * v.y(), v.z()};
}

inline Vec3 direction_at(double angle, double azimuth) {
  return turned({std::sin(angle), 0, std::cos(angle)}, azimuth);
}

/// Places of the plane and azimuths, evenly spread; `use(place, azimuth)` for each. Other points than those
/// of `sample_visible_normals`.
template <class Use>
void for_places(const DisplacedPlane& plane, int count, const Use& use) {
  const auto fraction = [](double number) { return number - std::floor(number); };
  for (int sample = 0; sample < count; ++sample) {
    // The plane by powers of the plastic number's inverse (Roberts 2018), the circle in turn.
    const Vec2 uv(fraction(0.5 + sample * 0.7548776662466927), fraction(0.5 + sample * 0.5698402909980532));
    use(Vec2(uv.cwiseProduct(plane.sides())), 2 * std::numbers::pi * (sample + 0.5) / count);
  }
}

/// Normals that a viewer sees, in the viewer's frame, by rays that start evenly over the plane; from one
/// azimuth when it is given. `use(normal)` for each.
template <class Use>
void for_seen_normals(const DisplacedPlane& plane, double view_angle, int count, const Use& use,
                      std::optional<double> fixed_azimuth = {}) {
  for_places(plane, count, [&](const Vec2& place, double azimuth) {
    if (fixed_azimuth) azimuth = *fixed_azimuth;
    const Vec3 viewer = direction_at(view_angle, azimuth);
    const Vec3 start = Vec3(place.x(), place.y(), plane.heights().max) + 0.01 * viewer;
    if (const auto hit = plane.first_hit(start, -viewer)) use(turned(hit->normal, -azimuth), azimuth, *hit);
  });
}

}  // namespace recede::test
