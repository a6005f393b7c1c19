// filtered_reflectance: half-spheres on a plane, seen from so far that they can't be told apart: how much
// light they send to a viewer, by their facets, and by rays that meet them.
#include <recede/geometry/error.h>
#include <recede/render/displaced_plane.h>
#include <recede/render/filtered_reflectance.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>
#include <vector>

namespace {

recede::DisplacementMap make_half_spheres() {
  constexpr int k_side = 32;
  std::vector<float> heights;
  for (int at = 0; at < k_side * k_side; ++at) {
    const double x = (at % k_side + 0.5) / k_side - 0.5, y = (at / k_side + 0.5) / k_side - 0.5;
    heights.push_back(static_cast<float>(std::sqrt(std::max(0.0, 0.16 - x * x - y * y))));
  }
  return {k_side, k_side, std::move(heights), recede::MapBorder::periodic};
}

/// The mean over the plane of what a viewer sees, matt and white, in the light of one direction.
double traced(const recede::DisplacedPlane& plane, const recede::Vec3& viewer, const recede::Vec3& light) {
  constexpr int k_side = 200;
  double sum = 0;
  for (int at = 0; at < k_side * k_side; ++at) {
    const recede::Vec3 place((at % k_side + 0.5) / k_side, (at / k_side + 0.5) / k_side, plane.heights().max);
    const recede::Vec3 start = place + 1e-6 * viewer;
    const auto hit = plane.first_hit(start, -viewer);
    if (!hit || plane.first_hit(start - hit->t * viewer + 1e-6 * hit->normal, light)) continue;
    sum += std::max(0.0, hit->normal.dot(light)) / std::numbers::pi;
  }
  return sum / (k_side * k_side);
}

}  // namespace

int main() try {
  const recede::DisplacementMap map = make_half_spheres();
  const recede::FacetLevels levels(map);
  std::cout << levels.count() << " levels in " << levels.bytes() << " bytes\n";

  const recede::FacetDistribution facets = levels.texel(levels.count() - 1, 0, 0).unpacked();
  const recede::FacetMaterial white{.albedo = 1, .reflection = 0};
  const recede::Vec3 light = recede::Vec3(-1, 0, 1).normalized();
  for (const double degrees : {0, 30, 60, 75}) {
    const double angle = degrees * std::numbers::pi / 180;
    const recede::Vec3 viewer(std::sin(angle), 0, std::cos(angle));
    const double filtered = recede::filtered_reflectance(facets, viewer, light, white) * light.z();
    const double by_rays = traced(recede::DisplacedPlane(map, {1, 1}), viewer, light);
    std::cout << degrees << " degrees: " << filtered << ", by rays " << by_rays << '\n';
  }
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
