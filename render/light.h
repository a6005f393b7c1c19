// The light of a picture: one distant lamp and a sky.
#pragma once

#include <recede/geometry/vec.h>
#include <recede/render/image.h>

namespace recede {

/// Lights that travel with the camera, so that a model is lit alike from every side. A white surface that
/// faces the lamp under no sky has the lamp's colour.
struct Light {
  /// Towards the lamp in the camera's frame: x to the right, y upwards, z towards the viewer. Any length.
  Vec3 toward{-0.55, 0.75, 0.8};
  Rgb lamp{0.66f, 0.65f, 0.63f};
  Rgb sky{0.32f, 0.34f, 0.38f};     ///< added where a surface faces upwards in the image
  Rgb ground{0.16f, 0.16f, 0.16f};  ///< added where it faces downwards; in between the two are mixed
};

}  // namespace recede
