#include <recede/geometry/error.h>
#include <recede/render/curved_visibility.h>

#include <cmath>

namespace recede {
namespace {

/// The direction to a point that lies at `offset` on the flat surface, seen from `height` above its origin.
/// Circles are taken as parabolas, as is right for radii that are large beside the offset.
Vec3 bent(const Vec3& offset, double height, const BaseCurvature& curvature) {
  const double there = height + offset.z();
  const double x = offset.x(), y = offset.y();
  const Vec3 moved(x * (1 + there * curvature.along_u), y * (1 + there * curvature.along_v),
                   offset.z() - (curvature.along_u * x * x + curvature.along_v * y * y) / 2);
  return moved.normalized();
}

/// Directions to the sky move as the one beside them that moves farthest: between the last place that is seen
/// and the crest in front of the sky, the way that places move still grows.
void move_along(const HeightFieldVisibility& visibility, std::size_t place, std::vector<Vec3>& directions) {
  const std::vector<Vec3>& flat = visibility.sphere.directions;
  std::vector<Vec3> farthest(flat.size(), Vec3::Zero());
  for (const DirectionTriangle& triangle : visibility.sphere.triangles) {
    for (std::size_t k = 0; k < 6; ++k) {
      const auto from = static_cast<std::size_t>(triangle[k % 3]);
      const auto to = static_cast<std::size_t>(triangle[(k + 1 + k / 3) % 3]);
      if (!visibility.seen_from(place, from).is_place()) continue;
      const Vec3 way = directions[from] - flat[from];
      if (way.squaredNorm() > farthest[to].squaredNorm()) farthest[to] = way;
    }
  }
  for (std::size_t i = 0; i < flat.size(); ++i) {
    if (visibility.seen_from(place, i).is_nothing()) directions[i] = (flat[i] + farthest[i]).normalized();
  }
}

}  // namespace

BentDirections bend_directions(const HeightFieldVisibility& visibility, std::size_t place,
                               const BaseCurvature& curvature) {
  if (!std::isfinite(curvature.along_u) || !std::isfinite(curvature.along_v))
    throw OptionError("the curvatures of a surface are finite numbers");
  const SphereDirections& sphere = visibility.sphere;
  const Vec3& normal = visibility.normals[place];
  BentDirections result{
      .directions = sphere.directions, .weights = std::vector<double>(sphere.size(), 1.0), .normal = normal};
  if (curvature.is_flat()) return result;
  const double height = visibility.heights[place];
  result.normal = Vec3(normal.x() / (1 + height * curvature.along_u),
                       normal.y() / (1 + height * curvature.along_v), normal.z())
                      .normalized();
  for (std::size_t i = 0; i < sphere.size(); ++i) {
    if (!visibility.seen_from(place, i).is_place()) continue;
    const Vec3 offset = static_cast<double>(visibility.distance_from(place, i)) * sphere.directions[i];
    result.directions[i] = bent(offset, height, curvature);
  }
  move_along(visibility, place, result.directions);
  const std::vector<double> before = solid_angles(sphere.directions, sphere.triangles);
  const std::vector<double> after = solid_angles(result.directions, sphere.triangles);
  for (std::size_t i = 0; i < sphere.size(); ++i) result.weights[i] = after[i] / before[i];
  return result;
}

}  // namespace recede
