// Rays against a scene. All tracing goes through here, so that what a ray carries along stands in one place.
#pragma once

#include <recede/render/detail/ray_context.h>
#include <recede/render/detail/scene_data.h>

#include <limits>

namespace recede::detail {

using Vec3f = Eigen::Vector3f;

/// What rays meet of a displaced surface with appearances.
enum class SurfaceShape {
  displaced,  ///< the heights, or a part of them
  base,       ///< the surface of mean height, without detail
  envelope    ///< what holds all heights: the surface of largest height
};

struct RayTarget {
  SurfaceShape shape = SurfaceShape::displaced;
  float fraction = 1;  ///< of the displacement
};

/// In the scaled scene.
struct Ray {
  Vec3f origin, direction;  ///< unit
  float length = std::numeric_limits<float>::infinity();
  /// Where it starts: flat, so it can't meet it again, whatever rounding says.
  SurfacePart from = {};
  RayTarget target = {};
};

struct Hit {
  SurfacePart part;
  float u = 0, v = 0;     ///< weights of the triangle's second and third corner; of a displaced surface as
                          ///< Embree has them, see `DisplacedPatch`
  float distance = 0;     ///< along the ray
  Vec3f origin{0, 0, 0};  ///< of the ray
  Vec3f front{0, 0, 0};   ///< normal on the side from which corners run counter-clockwise, any length
};

/// The first surface along the ray. False: none.
bool nearest_hit(const SceneData& scene, const Ray& ray, Hit& hit);

/// Whether a surface is in the way.
bool occluded(const SceneData& scene, const Ray& ray);

inline constexpr int k_packet_side = 4;  ///< a packet holds rays of 4 x 4 neighbouring pixels
inline constexpr int k_lanes = k_packet_side * k_packet_side;

/// Rays that run side by side.
struct RayPacket {
  alignas(64) int active[k_lanes];  ///< -1, or 0 for lanes that stay idle
  alignas(64) RTCRayHit16 rays;
  Vec3f directions[k_lanes];
  float entry[k_lanes];  ///< from the camera to the ray's origin, units of the scaled scene
  std::array<std::uint32_t, k_lanes> small;  ///< of hits of displaced surfaces, as in `SurfacePart`

  bool hits(int lane) const { return active[lane] != 0 && rays.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID; }
  Hit hit(int lane) const {
    return {{rays.hit.geomID[lane], rays.hit.primID[lane], small[static_cast<std::size_t>(lane)]},
            rays.hit.u[lane],
            rays.hit.v[lane],
            rays.ray.tfar[lane],
            Vec3f(rays.ray.org_x[lane], rays.ray.org_y[lane], rays.ray.org_z[lane]),
            Vec3f(rays.hit.Ng_x[lane], rays.hit.Ng_y[lane], rays.hit.Ng_z[lane])};
  }
};

/// `nearest_hit` of all active lanes.
void nearest_hits(const SceneData& scene, RayPacket& packet, const RayTarget& target = {});

}  // namespace recede::detail
