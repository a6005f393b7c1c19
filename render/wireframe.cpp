#include <recede/render/detail/wireframe.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recede::detail {

namespace {

// How much of the sample lies on a line, 0 to 1. Distances are measured across the ray, where the picture
// shows them.
float line_cover(const MeshData& mesh, const Wireframe& wireframe, const Hit& hit, const Vec3f& direction,
                 float pixel) {
  constexpr float k_unseen = 3, k_clear = 12;  // sides of polygons in pixels between which lines fade in
  const std::uint32_t triangle = hit.part.primitive;
  const std::array<std::uint32_t, 3>& vertices = mesh.triangles[triangle];
  const Vec3f weights(1 - hit.u - hit.v, hit.u, hit.v);
  std::array<Vec3f, 3> corners;
  Vec3f place = Vec3f::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    corners[k] = Vec3f(mesh.positions[vertices[k]].data());
    place += weights[static_cast<int>(k)] * corners[k];
  }
  const Vec3f front = (corners[1] - corners[0]).cross(corners[2] - corners[0]).stableNormalized();
  const float side = std::sqrt(mesh.polygon_areas[triangle] * std::abs(front.dot(direction))) / pixel;
  const float fade = std::clamp((side - k_unseen) / (k_clear - k_unseen), 0.0f, 1.0f);
  if (fade == 0) return 0;
  const float half_width = static_cast<float>(wireframe.width) / 2;
  float cover = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if ((mesh.polygon_sides[triangle] >> k & 1) == 0) continue;
    const Vec3f across = direction.cross(corners[(k + 1) % 3] - corners[k]).stableNormalized();
    const float distance = std::abs(across.dot(corners[k] - place)) / pixel;
    cover = std::max(cover, std::clamp(half_width + 0.5f - distance, 0.0f, 1.0f));
  }
  return fade * cover;
}

}  // namespace

float line_factor(const MeshData& mesh, const Wireframe& wireframe, const Hit& hit, const Vec3f& direction,
                  float pixel) {
  return 1 - static_cast<float>(wireframe.darkness) * line_cover(mesh, wireframe, hit, direction, pixel);
}

}  // namespace recede::detail
