#include "cloud_check.h"

#include <algorithm>
#include <cmath>

namespace recede::bench {

bool CloudCheck::is_sound(double largest_deviation) const {
  // Distances of coordinates that are rounded; angles of cosines near 1.
  constexpr double k_distance_room = 1e-9, k_angle_room = 1e-6;
  return distance <= 1 + k_distance_room && deviation <= largest_deviation + k_angle_room && uncovered == 0 &&
         repeated == 0;
}

namespace {

// Half of the depth of a face along its normal.
double bend_of(const PolygonSoup& model, Index face, const Vec3& normal) {
  const Vec3& first = model.positions[model.face(face).front()];
  double low = 0, high = 0;
  for (const Index corner : model.face(face)) {
    const double at = (model.positions[corner] - first).dot(normal);
    low = std::min(low, at);
    high = std::max(high, at);
  }
  return (high - low) / 2;
}

// Whether rounding of coordinates leaves a face a direction.
bool has_direction(const PolygonSoup& model, Index face, const Vec3& area, double largest_coordinate) {
  constexpr double k_rounding = 1e-12;
  double longest = 0;
  const Vec3& first = model.positions[model.face(face).front()];
  for (const Index corner : model.face(face))
    longest = std::max(longest, (model.positions[corner] - first).norm());
  return area.norm() > k_rounding * largest_coordinate * longest;
}

}  // namespace

CloudCheck check_cloud(const PolygonSoup& model, const BillboardCloud& cloud, bool is_two_sided) {
  CloudCheck check;
  std::vector<unsigned> uses(model.n_faces(), 0);
  double largest_coordinate = 0;
  for (const Vec3& point : model.positions)
    largest_coordinate = std::max(largest_coordinate, point.cwiseAbs().maxCoeff());
  for (const Billboard& billboard : cloud.billboards) {
    const Vec3 normal = billboard.normal();
    for (const Index face : billboard.faces) {
      ++uses[face];
      const Vec3 area = vector_area(model, face), of_face = area.normalized();
      const double cosine = is_two_sided ? std::abs(of_face.dot(normal)) : of_face.dot(normal);
      const bool is_bent = bend_of(model, face, of_face) > cloud.error;
      check.bent += is_bent ? 1 : 0;
      if (!is_bent && has_direction(model, face, area, largest_coordinate))
        check.deviation = std::max(check.deviation, std::acos(std::clamp(cosine, -1.0, 1.0)));
      for (const Index corner : model.face(face)) {
        const double distance = std::abs((model.positions[corner] - billboard.center).dot(normal));
        check.distance = std::max(check.distance, distance / cloud.error);
      }
    }
  }
  std::size_t uncovered = 0;
  for (Index face = 0; face < uses.size(); ++face) {
    if (uses[face] > 1) ++check.repeated;
    if (uses[face] > 0) continue;
    ++uncovered;
    if (has_direction(model, face, vector_area(model, face), largest_coordinate)) ++check.uncovered;
  }
  // Those without an area may be left out, and no others; the cloud says how many it left out.
  check.uncovered = std::max(check.uncovered, uncovered - std::min(uncovered, cloud.left_out));
  return check;
}

std::size_t count_texels(const BillboardCloud& cloud) {
  double texels = 0;
  for (const Billboard& billboard : cloud.billboards) {
    const Vec2 sides = 2 / cloud.error * billboard.half_sizes;
    texels += std::max(1.0, std::ceil(sides.x())) * std::max(1.0, std::ceil(sides.y()));
  }
  return static_cast<std::size_t>(texels);
}

}  // namespace recede::bench
