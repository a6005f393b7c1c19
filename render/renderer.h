// Pictures of scenes: rays from the camera, shaded where they hit.
#pragma once

#include <recede/geometry/progress.h>
#include <recede/render/camera.h>
#include <recede/render/light.h>
#include <recede/render/rendering_transition.h>
#include <recede/render/scene.h>

#include <optional>

namespace recede {

/// Lines along the sides of polygons; diagonals of triangulated polygons get none.
struct Wireframe {
  double width = 1.1;     ///< of the lines, pixels
  double darkness = 0.8;  ///< share of the light that a line takes away, 0 to 1
};

/// Which light reaches surfaces, and how far it is followed.
enum class LightTransport {
  camera,  ///< lamps that travel with the camera, without shadows
  direct,  ///< light straight from the scene's lights, with shadows; `Lighting::ambient` for all the rest
  path     ///< that, and light that surfaces pass on, by paths of several bounces
};

/// How the light of rectangles and environments is found. All ways have the same mean; they differ in noise.
enum class LightSampling {
  both,    ///< each by its share, so that neither small nor near lights are noisy
  lights,  ///< by directions towards lights only
  surface  ///< by directions that the surface scatters to only
};

/// By which method displaced surfaces with appearances are drawn (`SceneOptions::appearance`).
enum class Representation {
  automatic,    ///< each ray by what it needs, see `RenderOptions::transition`
  brdf,         ///< a table of what all bumps together scatter
  bump,         ///< redistributed bump map
  displacement  ///< geometry
};

struct RenderOptions {
  /// Samples spread over each pixel, 1 to 65536; with the camera's light at most 1024, in a fixed pattern
  /// that fills both axes evenly.
  int samples_per_pixel = 4;
  Rgb background = rgb_from_hex(0xe3e7ec);
  LightTransport transport = LightTransport::camera;
  CameraLight camera_light = {};  ///< for `LightTransport::camera`
  Lighting lighting = {};         ///< for the others
  /// Of a path after the first surface, 0 to 1000: 0 is direct light alone.
  int max_bounces = 4;
  LightSampling light_sampling = LightSampling::both;
  /// Above 0: blocks of 4 x 4 pixels end before `samples_per_pixel`, from 16 samples on, once their standard
  /// error is at most this as a share of the step from black to white (sRGB-encoded). What is so rare that no
  /// sample of a block has met it is missed.
  double noise = 0;
  Representation representation = Representation::automatic;
  /// Where methods change. Unset: by `transition_for_wavelength`, for the appearance's waves and the camera's
  /// pixels.
  std::optional<TransitionOptions> transition = {};
  /// False colours instead of light: green is displacement, blue the bump map, red the table, and what lies
  /// between them a mixture. Surfaces without appearances are grey.
  bool show_methods = false;
  /// Set: draws lines. They fade where polygons shrink to a few pixels, so that a fine mesh isn't a black
  /// blot.
  std::optional<Wireframe> wireframe = {};
};

/// The picture of the scene's nearest surface along each ray: matt, both sides alike. Pixels are means over
/// their square.
///
/// Light of the scene's lights follows the rendering equation split into direct and indirect light: shadow
/// rays to every light, and either the ambient constant or paths of cosine-distributed rays on which no light
/// is counted twice. Means over samples are unbiased but for `max_bounces`, `noise`, and shading normals
/// (what would come from below a face is black).
///
/// Same bytes for any number of threads. Throws `OptionError` for options out of range or lights that can't
/// be, `InputError` for an environment with numbers that aren't finite, and `Cancelled`.
Image render(const Scene& scene, const Camera& camera, const RenderOptions& options = {},
             Progress* progress = nullptr);

}  // namespace recede
