// What a texel of a billboard shows of its model, and sends of each light, by rays.
#pragma once

#include <recede/lod/detail/billboard_rays.h>
#include <recede/render/billboard_reflectance.h>
#include <recede/render/detail/surface_point.h>
#include <recede/render/scene.h>

#include <vector>

namespace recede::detail {

/// A texel from one side.
struct SidedTexel {
  std::uint32_t billboard = 0;
  bool is_back = false;
  int x = 0, y = 0;  ///< from the billboard's upper left corner
};

/// The axes of a billboard's side: columns are x, y and what faces the viewer, a right-handed frame.
Eigen::Matrix3d axes_of(const Billboard& billboard, bool is_back);

class TexelLight {
 public:
  /// Keeps references. `cloud` has its billboards as `textures` have them.
  TexelLight(const PolygonSoup& model, const BillboardCloud& cloud, const BillboardTextures& textures,
             const BillboardReflectanceOptions& options);

  /// The share of a texel that faces cover in a view.
  float coverage(const SidedTexel& texel, std::size_t view) const;

  /// By light and colour, into as many numbers. False where the view shows nothing: they are 0 then. Other
  /// `number`s draw other samples.
  bool add_radiance(const SidedTexel& texel, std::size_t view, std::uint32_t number, float* values) const;

 private:
  struct Place {
    TrianglePlace on_triangle;
    int sample;
  };
  std::vector<Place> places_of(const SidedTexel& texel, std::size_t view, const Vec3& viewer) const;
  bool shows_others(const SidedTexel& texel) const;
  void add_light(const SurfacePoint& point, const Rgb& share, const std::vector<Vec3>& lights,
                 float* values) const;
  Hit hit_at(const TrianglePlace& place) const;

  const BillboardTextures& textures_;
  const BillboardReflectanceOptions& options_;
  BillboardRays rays_;
  Scene scene_;
  std::vector<Vec3> views_, lights_;  // along a side's axes
};

}  // namespace recede::detail
