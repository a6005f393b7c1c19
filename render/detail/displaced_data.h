// The inside of a DisplacedMesh, for the renderer only.
#pragma once

#include <recede/lod/detail/embree_device.h>
#include <recede/render/detail/displaced_patches.h>
#include <recede/render/detail/ray_context.h>
#include <recede/render/displaced_mesh.h>

namespace recede {

struct DisplacedMesh::Data {
  Data(const PolygonSoup& base, DisplacementMap heights, const DisplacedMeshOptions& options);
  Data(const Data&) = delete;
  Data& operator=(const Data&) = delete;

  detail::PatchArrays arrays() const;
  void build_scene();
  void take_map(DisplacementMap heights);
  /// A ray of the scaled scene starts nearer and has a unit direction.
  struct RayScale {
    double length = 1;  ///< of the direction, scaled scene
    double start = 0;   ///< from the ray's origin, scaled scene

    double t_of(float scene_t) const { return (static_cast<double>(scene_t) + start) / length; }
  };
  /// False for a ray that can't meet anything. Throws `OptionError` for a fraction that can't be had.
  bool set_ray(const Vec3& origin, const Vec3& direction, const DisplacedRayOptions& options, RTCRay& ray,
               RayScale& scale) const;
  double height_span() const;  ///< from the least to the largest height, scaled scene
  std::size_t n_parts() const {
    return patches.parts.empty() ? patches.patches.size() : patches.parts.size();
  }
  /// A place in a patch as one in its base triangle.
  struct BasePlace {
    std::uint32_t patch = 0;
    bool is_second = false;       ///< of the patch's two triangles
    Vec3 patch_weights{0, 0, 0};  ///< of `corners()`
    Index triangle = 0;           ///< of `triangulate(base)`
    Vec3 weights{0, 0, 0};        ///< of its corners
    Vec2 uv{0, 0};

    /// Of the patch: a, b, d or c, d, b.
    std::array<std::size_t, 3> corners() const {
      return is_second ? std::array<std::size_t, 3>{2, 3, 1} : std::array<std::size_t, 3>{0, 1, 3};
    }
  };
  BasePlace base_place(std::uint32_t part, std::uint32_t small, double u, double v) const;

  DisplacementMap map;
  std::optional<HeightBounds> bounds;
  detail::SceneFrame frame;
  detail::DisplacedPatches patches;
  bool partial = false;
  detail::HeightMapView view;
  detail::OwnedScene scene;  ///< null until `build_scene`
};

namespace detail {

/// A geometry of one primitive for each part. `data` stays in place. Rays bring a `RayContext`.
RTCGeometry displaced_geometry(RTCDevice device, const DisplacedMesh::Data& data);

/// Sets the flags of a scene that is to hold it, and what makes the scene smaller.
void save_memory(RTCScene scene, RTCSceneFlags flags, const DisplacedMesh::Data& data);

}  // namespace detail
}  // namespace recede
