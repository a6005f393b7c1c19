// Shells with volume textures in scenes.
#pragma once

#include <recede/render/camera.h>
#include <recede/render/image.h>
#include <recede/shells/textured_shell.h>

#include <optional>

namespace recede {

/// From where textures are seen, which says how fine they are drawn: texels get no smaller than pixels.
struct VolumeView {
  Vec3 eye = Vec3::Zero();
  double pixel_angle = 0;  ///< between two pixels, radians
};

/// That of a camera; its pixels are as wide as in the middle of the picture. Throws as `frame_of`.
VolumeView volume_view(const Camera& camera);

/// A textured shell. Rays meet the surface on which opacity is a half, from both sides, with normals of the
/// opacity's gradient in the shell's frame; and where the layer ends inside of the matter, that end. The base
/// isn't drawn: where it shows, it is a surface of its own.
///
/// With `view`, what is far away is drawn from smaller versions: the last level of surfaces fades into the
/// first of transparent matter between the level before it and its own, and all transparent ones into the
/// next. Which of them a ray sees is drawn by lot, as is where transparent matter stops it: means over
/// samples are those of the matter.
struct PlacedVolume {
  TexturedShell textured;
  Rgb color{0.7f, 0.7f, 0.7f};  ///< where the texture has no colours
  std::optional<VolumeView> view = {};
};

}  // namespace recede
