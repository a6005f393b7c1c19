// Light that leaves a surface towards a camera, by shadow rays and paths.
#pragma once

#include <recede/render/detail/sample_stream.h>
#include <recede/render/detail/scene_lights.h>
#include <recede/render/detail/surface_point.h>

namespace recede::detail {

/// One sample of the rendering equation, split as L = L_direct + L_indirect: direct light by rays to lights
/// and by scattered rays that find lights, indirect light by the ambient constant or by scattered rays that
/// go on from the surface they hit.
class PathTracer {
 public:
  /// What it is given must live as long as this.
  PathTracer(const SceneData& scene, const SceneLights& lights, const RenderOptions& options)
      : scene_(scene), lights_(lights), options_(options) {}

  /// Radiance along a camera's ray that hits a surface, by the method that `shares` say. Paths stay on the
  /// geometry on which they begin, and see its base by the table.
  Rgb radiance(const Hit& hit, const Vec3f& direction, MethodShares shares, SampleStream& numbers) const;

 private:
  Rgb drawn_light(const SurfacePoint& point, SampleStream& numbers) const;
  Rgb last_light(const SurfacePoint& point, const ScatterSample& scatter) const;

  const SceneData& scene_;
  const SceneLights& lights_;
  const RenderOptions& options_;
};

}  // namespace recede::detail
