#include <recede/geometry/error.h>
#include <recede/render/detail/ground_disc.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace recede::detail {

namespace {

constexpr double k_inner_radius = 0.25;  // of the longest side
constexpr int k_doublings = 8;
constexpr Index k_around = 48;

// Below the middle of the models, at the height of their lowest vertex.
Vec3 foot_of(std::span<const std::span<const Vec3>> models, const Box3& box, const Vec3& up) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const std::span<const Vec3> points : models) {
    for (const Vec3& point : points) lowest = std::min(lowest, up.dot(point - box.center()));
  }
  return box.center() + lowest * up;
}

}  // namespace

// Rings whose width grows with their distance: near the models, where rays are traced to the last digit,
// triangles are as small as they are.
PolygonSoup ground_disc(std::span<const std::span<const Vec3>> models, const Ground& ground) {
  if (!(ground.up.norm() > 0) || !ground.up.allFinite())
    throw OptionError("the ground needs a direction that points up");
  const Vec3 up = ground.up.normalized(), across = up.unitOrthogonal(), along = up.cross(across);
  Box3 box;
  for (const std::span<const Vec3> points : models) {
    for (const Vec3& point : points) box.extend(point);
  }
  const double extent = box.sizes().maxCoeff() > 0 ? box.sizes().maxCoeff() : 1.0;
  PolygonSoup disc;
  disc.positions.push_back(foot_of(models, box, up));
  for (int ring = 0; ring <= k_doublings; ++ring) {
    for (Index i = 0; i < k_around; ++i) {
      const double angle = 2 * std::numbers::pi * i / k_around;
      disc.positions.push_back(disc.positions[0] + std::ldexp(k_inner_radius * extent, ring) *
                                                       (std::cos(angle) * across + std::sin(angle) * along));
    }
  }
  for (Index i = 0; i < k_around; ++i) {
    const Index next = (i + 1) % k_around;
    disc.add_face(std::array<Index, 3>{0, 1 + i, 1 + next});
    for (Index ring = 0; ring < k_doublings; ++ring) {
      const Index inner = 1 + ring * k_around, outer = inner + k_around;
      disc.add_face(std::array<Index, 4>{inner + i, outer + i, outer + next, inner + next});
    }
  }
  const Eigen::Vector3d color = ground.color.cast<double>();
  disc.materials.push_back(
      {.name = "ground", .base_color = Vec4(color.x(), color.y(), color.z(), 1), .base_color_texture = ""});
  disc.face_materials.assign(disc.n_faces(), 0);
  return disc;
}

}  // namespace recede::detail
