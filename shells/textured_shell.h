// Shells with volume textures in them.
#pragma once

#include <recede/shells/shell.h>
#include <recede/shells/volume_mipmap.h>

#include <memory>

namespace recede {

/// From the texture coordinates of a shell's base to (s, t): another offset moves the texture over the
/// surface.
struct VolumeCoordinates {
  Vec2 repeat{1, 1};  ///< periods to a texture coordinate of 1; below 0 mirrors
  Vec2 offset{0, 0};  ///< periods

  Vec2 of(const Vec2& uv) const { return uv.cwiseProduct(repeat) + offset; }
};

/// A texture in one layer of a shell.
struct TexturedShell {
  std::shared_ptr<const Shell> shell{};  ///< its base has texture coordinates
  ShellSide side = ShellSide::exterior;  ///< exterior or interior: a layer that the shell has
  std::shared_ptr<const VolumeMipmap> texture{};
  VolumeCoordinates coordinates{};

  /// Throws `InputError` when the shell hasn't got the layer or texture coordinates, there is no texture, or
  /// its coordinates aren't finite or repeat 0 times.
  const ShellLayer& layer() const;
};

}  // namespace recede
