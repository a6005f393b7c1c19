// How displaced surfaces look where rays hit them.
#pragma once

#include <recede/lod/detail/map_surface.h>
#include <recede/render/detail/appearance_look.h>
#include <recede/render/detail/displaced_data.h>
#include <recede/render/detail/tracing.h>

#include <optional>

namespace recede::detail {

struct DisplacedLook {
  DisplacedLook(const PolygonSoup& base, DisplacementMap heights, const DisplacedMeshOptions& options)
      : surface(base, std::move(heights), options) {}
  /// With the normals of their normal map.
  DisplacedLook(const BakedMaps& baked, const DisplacedMeshOptions& options);
  DisplacedLook(const DisplacedLook&) = delete;
  DisplacedLook& operator=(const DisplacedLook&) = delete;

  DisplacedMesh::Data surface;
  std::optional<BakedMaps> maps = {};              ///< set where there is a normal map
  std::optional<MapTriangles> map_triangles = {};  ///< of `maps`
  bool is_flat = false;                            ///< small triangles are shaded as facets
  /// Set where other methods than displacement may draw the surface. Normals are then those of the bump map.
  std::optional<AppearanceLook> appearance = {};
};

/// Whether a hit is one of the base, which rays meet that are asked to.
inline bool is_on_base(const Hit& hit) { return hit.part.small == SurfacePart::k_none; }

/// The hit of a displaced surface as one of its base: primitive, u and v are those of the base's triangle.
Hit hit_of_base(const DisplacedLook& look, const Hit& hit);

/// The unit normal for shading, on the base's front: the normal map's, or that of the surface with heights
/// whose slopes are interpolated between texels, so that texels don't show as facets. For surfaces without
/// appearances.
Vec3 displaced_normal(const DisplacedLook& look, const Hit& hit);

/// How far rays that leave a small triangle must start off it, so that rounding puts them on its right side.
double displaced_rounding_bound(const DisplacedLook& look, const MeshData& base, const Hit& hit,
                                const Vec3& position);

}  // namespace recede::detail
