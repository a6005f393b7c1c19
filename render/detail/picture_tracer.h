// What every sample of a picture's pixels shows.
#pragma once

#include <recede/render/detail/camera_rays.h>
#include <recede/render/detail/path_tracer.h>
#include <recede/render/detail/seen_surfaces.h>

#include <array>
#include <optional>
#include <vector>

namespace recede::detail {

/// Colours of a block's pixels.
struct BlockColors {
  std::array<float, k_lanes> red, green, blue;

  void set(int lane, const Rgb& color) {
    const auto i = static_cast<std::size_t>(lane);
    red[i] = color.x();
    green[i] = color.y();
    blue[i] = color.z();
  }
};

class PictureTracer {
 public:
  /// What it is given must live as long as this. Throws as `render` does.
  PictureTracer(const SceneData& scene, const Camera& camera, const RenderOptions& options);

  int width() const { return rays_.width(); }
  int height() const { return rays_.height(); }

  /// A sample of 4 x 4 pixels; those outside the image get anything. Depends on nothing but the arguments.
  void sample_block(int left, int top, int sample, BlockColors& colors) const;

 private:
  void sample_by_camera_light(int left, int top, int sample, BlockColors& colors) const;
  void sample_by_scene_light(int left, int top, int sample, BlockColors& colors) const;
  Rgb camera_light_on(const SurfaceLook& look) const;
  Rgb method_color_of(const SeenSurface& surface, const Vec3f& direction) const;
  float line_factor_at(const RayPacket& packet, int lane, const Hit& hit) const;

  const SceneData& scene_;
  const RenderOptions& options_;
  CameraRays rays_;
  SeenSurfaces surfaces_;
  std::vector<Vec2> pattern_;  // of the camera's light
  Vec3 toward_lamp_, up_;
  std::optional<SceneLights> lights_;  // of the scene
  std::optional<PathTracer> paths_;
};

}  // namespace recede::detail
