// The inside of a DisplacedMesh, for the renderer only.
#pragma once

#include <recede/render/detail/displaced_patches.h>
#include <recede/render/displaced_mesh.h>

#include <embree3/rtcore.h>

namespace recede {

struct DisplacedMesh::Data {
  Data(const PolygonSoup& base, DisplacementMap heights, const DisplacedMeshOptions& options);
  ~Data();
  Data(const Data&) = delete;
  Data& operator=(const Data&) = delete;

  detail::PatchArrays arrays() const;
  void take_map(DisplacementMap heights);
  /// False for a ray that can't meet anything. Throws `OptionError` for a fraction that can't be had.
  bool set_ray(const Vec3& origin, const Vec3& direction, const DisplacedRayOptions& options,
               RTCRay& ray) const;
  std::size_t n_parts() const {
    return patches.parts.empty() ? patches.patches.size() : patches.parts.size();
  }
  Hit hit_of(std::uint32_t part, const detail::PatchRayQuery& query) const;

  DisplacementMap map;
  std::optional<HeightBounds> bounds;
  detail::SceneFrame frame;
  detail::DisplacedPatches patches;
  bool partial = false;
  detail::HeightMapView view;
  RTCScene scene = nullptr;
};

namespace detail {

/// What travels with rays through Embree beside the ray.
struct DisplacedContext {
  RTCIntersectContext embree;
  float fraction = 1;
  std::uint32_t triangle = 0;  ///< of the hit, as in `PatchRayQuery`
};

/// A geometry of one primitive for each part. `data` stays in place. Rays bring a `DisplacedContext`.
RTCGeometry displaced_geometry(RTCDevice device, const DisplacedMesh::Data& data);

}  // namespace detail
}  // namespace recede
