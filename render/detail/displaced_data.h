// The inside of a DisplacedMesh, for the renderer only.
#pragma once

#include <recede/render/detail/displaced_patches.h>
#include <recede/render/detail/ray_context.h>
#include <recede/render/displaced_mesh.h>

namespace recede {

struct DisplacedMesh::Data {
  Data(const PolygonSoup& base, DisplacementMap heights, const DisplacedMeshOptions& options);
  ~Data();
  Data(const Data&) = delete;
  Data& operator=(const Data&) = delete;

  detail::PatchArrays arrays() const;
  void build_scene();
  void take_map(DisplacementMap heights);
  /// False for a ray that can't meet anything. Throws `OptionError` for a fraction that can't be had.
  bool set_ray(const Vec3& origin, const Vec3& direction, const DisplacedRayOptions& options,
               RTCRay& ray) const;
  std::size_t n_parts() const {
    return patches.parts.empty() ? patches.patches.size() : patches.parts.size();
  }
  /// A place in a patch as one in its base triangle.
  struct BasePlace {
    Index triangle = 0;  ///< of `triangulate(base)`
    Vec3 weights{0, 0, 0};
    Vec2 uv{0, 0};
  };
  BasePlace base_place(std::uint32_t part, std::uint32_t small, double u, double v) const;

  DisplacementMap map;
  std::optional<HeightBounds> bounds;
  detail::SceneFrame frame;
  detail::DisplacedPatches patches;
  bool partial = false;
  detail::HeightMapView view;
  RTCScene scene = nullptr;  ///< null until `build_scene`
};

namespace detail {

/// A geometry of one primitive for each part. `data` stays in place. Rays bring a `RayContext`.
RTCGeometry displaced_geometry(RTCDevice device, const DisplacedMesh::Data& data);

}  // namespace detail
}  // namespace recede
