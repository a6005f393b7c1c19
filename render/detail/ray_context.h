// What travels with rays through Embree beside the rays.
#pragma once

#include <embree3/rtcore.h>

#include <array>
#include <cstdint>

namespace recede::detail {

/// A part of a surface that Embree knows by number.
struct SurfacePart {
  static constexpr std::uint32_t k_none = 0xffffffffu;
  std::uint32_t object = RTC_INVALID_GEOMETRY_ID;  ///< among `SceneData::meshes`
  std::uint32_t primitive = RTC_INVALID_GEOMETRY_ID;
  std::uint32_t small = k_none;  ///< of a displaced surface: the small triangle, as in `PatchRayQuery`
};

struct RayContext {
  RTCIntersectContext embree;  ///< first, as Embree sees no more than this
  SurfacePart from = {};       ///< flat, and where the rays start: they can't meet it again
  float fraction = 1;          ///< of the displacement
  /// Of displaced surfaces, by the number that a ray has in `RTCRay::id`: the small triangle that it meets.
  std::array<std::uint32_t, 16> small{};
};

inline RayContext make_ray_context() {
  RayContext context;
  rtcInitIntersectContext(&context.embree);
  return context;
}

}  // namespace recede::detail
