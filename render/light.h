// The light of a picture: lamps that travel with the camera, or lights that stand in the scene.
//
// Lights of the scene have physical units per channel: radiance (what a camera records) in, say, watts per
// square metre and steradian. A matt white surface under an irradiance of pi has the radiance 1, the white of
// a screen. No number of a light is above 1e15. Places and lengths are object units; directions have any
// length but 0.
#pragma once

#include <recede/geometry/vec.h>
#include <recede/render/image.h>

#include <optional>
#include <vector>

namespace recede {

/// Lights that travel with the camera, so that a model is lit alike from every side: one distant lamp and a
/// sky, without shadows. A white surface that faces the lamp under no sky has the lamp's colour.
struct CameraLight {
  /// Towards the lamp in the camera's frame: x to the right, y upwards, z towards the viewer. Any length.
  Vec3 toward{-0.55, 0.75, 0.8};
  Rgb lamp{0.66f, 0.65f, 0.63f};
  Rgb sky{0.32f, 0.34f, 0.38f};     ///< added where a surface faces upwards in the image
  Rgb ground{0.16f, 0.16f, 0.16f};  ///< added where it faces downwards; in between the two are mixed
};

/// Shines alike in all directions from a point. At distance r a surface that faces it has the irradiance
/// intensity / r^2. It has no size and isn't seen itself.
struct PointLight {
  Vec3 position = Vec3::Zero();
  Rgb intensity = Rgb::Ones();  ///< power per solid angle
};

/// Shines from infinitely far, like the sun. It isn't seen itself.
struct DirectionalLight {
  Vec3 toward = Vec3::UnitY();        ///< from the scene to the light
  Rgb irradiance = Rgb::Constant(3);  ///< of a surface that faces it
  double angular_radius = 0;          ///< of its disc, radians, in [0, pi/2); 0: shadows have sharp borders
};

/// A parallelogram that shines from every point alike in all directions in front of it. It is light without a
/// body: it casts no shadow, and what lies behind shows through it, brightened by its radiance.
struct AreaLight {
  Vec3 corner = Vec3::Zero();
  Vec3 first_edge = Vec3::UnitX(), second_edge = Vec3::UnitY();  ///< from the corner to its neighbours
  Rgb radiance = Rgb::Ones();
  bool two_sided = false;  ///< otherwise it shines to where first_edge x second_edge points
};

/// Light from all around, infinitely far away.
struct EnvironmentLight {
  /// All directions by longitude (columns) and latitude (rows), as seen from inside. Row 0 is at `up`; the
  /// middle column is what a camera in front sees behind the model (see `front_of`), and columns go on to the
  /// right as that camera sees them. One pixel is light from everywhere alike. Negative values count as 0.
  Image radiance = Image(1, 1, Rgb::Ones());
  Vec3 up = Vec3::UnitY();
  double rotation = 0;  ///< of the environment about `up`, counter-clockwise seen from above, radians
  double scale = 1;     ///< factor of the radiance
  bool visible = true;  ///< behind the model; otherwise it lights, but the picture has its background there
};

/// Lights that stand in the scene.
struct Lighting {
  std::vector<PointLight> points = {};
  std::vector<DirectionalLight> directionals = {};
  std::vector<AreaLight> areas = {};
  std::optional<EnvironmentLight> environment = {};
  /// Radiance that stands for all light that other surfaces pass on, where that isn't traced: a surface of
  /// albedo R gets R * ambient.
  double ambient = 0.1;
};

/// A sun from the upper left of the front with soft borders of its shadows, and a soft sky that isn't visible
/// itself. `up` points upwards.
Lighting daylight(const Vec3& up = Vec3::UnitY());

}  // namespace recede
