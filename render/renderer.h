// Pictures of scenes: one ray per sample, shaded where it hits.
#pragma once

#include <recede/geometry/progress.h>
#include <recede/render/camera.h>
#include <recede/render/light.h>
#include <recede/render/scene.h>

#include <optional>

namespace recede {

/// Lines along the sides of polygons; diagonals of triangulated polygons get none.
struct Wireframe {
  double width = 1.1;     ///< of the lines, pixels
  double darkness = 0.8;  ///< share of the light that a line takes away, 0 to 1
};

struct RenderOptions {
  /// Samples spread over each pixel in a fixed pattern that fills both axes evenly, 1 to 1024.
  int samples_per_pixel = 4;
  Rgb background = rgb_from_hex(0xe3e7ec);
  Light light = {};
  /// Set: draws lines. They fade where polygons shrink to a few pixels, so that a fine mesh isn't a black
  /// blot.
  std::optional<Wireframe> wireframe = {};
};

/// The picture of the scene's nearest surface along each ray: matt, lit by `options.light` without shadows,
/// both sides alike. Pixels are means over their square. Same bytes for any number of threads. Throws
/// `OptionError` for options out of range, and `Cancelled`.
Image render(const Scene& scene, const Camera& camera, const RenderOptions& options = {},
             Progress* progress = nullptr);

}  // namespace recede
