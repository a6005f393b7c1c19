// What shading knows of a place on a surface, and how the surface scatters light: the one place for both.
#pragma once

#include <recede/render/detail/appearance_look.h>
#include <recede/render/detail/billboard_view.h>
#include <recede/render/detail/tracing.h>

namespace recede::detail {

/// A place of a surface with appearances that another method than displacement draws, or helps to draw.
struct MethodLook {
  const Appearance* appearance = nullptr;  ///< null: none
  MethodShares shares;
  SurfaceFrame frame;
  Vec3 toward_viewer;  ///< in the frame
};

/// How a surface looks where a ray hits it.
struct SurfaceLook {
  Vec3f normal;  ///< unit, for shading; turned to the side that is seen
  Rgb albedo;    ///< share of the light that it scatters back
  /// Of the mean over normals that differ within a ray's reach: light of a direction counts as much less.
  float normal_length = 1;
  MethodLook method = {};
  BillboardView billboard = {};  ///< with reflectance, which is then all that counts
};

/// `direction` is the ray's. `shares` count for surfaces with appearances.
SurfaceLook look_of(const SceneData& scene, const Hit& hit, const Vec3f& direction,
                    const MethodShares& shares = {});

/// The mean of max(0, N.L) over the normals N that are seen, for a lamp without shadows, and the mean of N.
double facing(const SurfaceLook& look, const Vec3& toward_light);
Vec3 mean_normal(const SurfaceLook& look);

/// Where a ray hits a surface; lengths of the scaled scene.
struct SurfacePoint {
  SurfacePart part;
  Vec3 position;          ///< on the triangle between the corners as Embree has them
  Vec3f start;            ///< for rays that leave: off the surface by a bound of the rounding
  Vec3 geometric_normal;  ///< unit, towards the side that is seen
  Vec3 normal;            ///< unit, for shading
  Rgb albedo;
  double normal_length = 1;  ///< as in `SurfaceLook`
  MethodLook method;
  BillboardView billboard;
  bool passes_on = false;  ///< paths go on from here, so that bumps also light each other
  RayTarget target;        ///< what rays from here meet

  /// A ray from here, which must lead to the side that is seen.
  Ray ray_towards(const Vec3& direction, float length = std::numeric_limits<float>::infinity()) const {
    return {start, direction.cast<float>(), length, part, target};
  }
};

/// Turns a hit into what shading needs. `direction` is the ray's; rays from here meet the geometry that goes
/// with `shares`.
SurfacePoint surface_point(const SceneData& scene, const Hit& hit, const Vec3f& direction,
                           const MethodShares& shares = {});

/// Radiance that the surface sends to the viewer per radiance that comes from a unit direction, per solid
/// angle: the BRDF times the cosine. Nothing from below the geometric horizon: a shading normal must not let
/// light shine through the surface. Billboards with reflectance have no horizon.
Rgb scattered(const SurfacePoint& point, const Vec3& toward);

/// A direction drawn in proportion to how the surface scatters.
struct ScatterSample {
  Vec3 direction;
  double density = 0;  ///< per solid angle
  Rgb weight;          ///< `scattered` over the density
};

/// False: the drawn direction leads nowhere, and counts as black.
bool sample_scattering(const SurfacePoint& point, const Vec2& random, ScatterSample& sample);

/// The density with which `sample_scattering` draws a direction.
double scattering_density(const SurfacePoint& point, const Vec3& toward);

}  // namespace recede::detail
