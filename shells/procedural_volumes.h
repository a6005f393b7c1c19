// Detail by formulas, for volume textures.
#pragma once

#include <recede/shells/volume_texture.h>

namespace recede {

/// A function for `make_volume`, periodic along s and t, and the lengths of a period.
struct ProceduralVolume {
  InsideDistance inside;
  Vec3 extent = Vec3::Ones();
  std::function<Vec3(const Vec3&)> color{};  ///< as in `VolumeOptions`
};

/// Its texture: `texels` along s, and along t and r that times the power of two that makes texels most nearly
/// cubes; at least 1.
VolumeTexture make_volume(const ProceduralVolume& volume, int texels, Progress* progress = nullptr);

struct ChainMailOptions {
  /// Radius of the wire over that of the rings, above 0 and at most 0.22, where rings would touch.
  double wire = 0.17;
};

/// Rings in rows, each through two rings of both rows beside it, that lean to opposite sides. A period has
/// two rings. The unit is a ring's radius.
ProceduralVolume chain_mail(const ChainMailOptions& options = {});

struct WeaveOptions {
  /// Radius of the threads over the distance between them, above 0 and at most 0.3, where threads would
  /// touch.
  double thread = 0.26;
  Vec3 warp_color{0.62, 0.20, 0.16}, weft_color{0.85, 0.78, 0.62};  ///< sRGB-encoded
};

/// Threads over and under each other. A period has two of each kind; the unit is the distance between
/// threads.
ProceduralVolume weave(const WeaveOptions& options = {});

struct BarkOptions {
  std::uint32_t seed = 1;
  double cracks = 0.8;  ///< share of the height that the deepest crack takes, 0 to 1
};

/// Plates between cracks that run along t, with a rough surface: gradient noise (Perlin 1985) and its ridges.
ProceduralVolume bark(const BarkOptions& options = {});

struct BubbleOptions {
  std::uint32_t seed = 1;
  int bubbles = 40;  ///< in a period, at least 1
  /// In lives of a bubble, any number: bubbles rise from the ground, grow and burst, and the next ones begin.
  double time = 0;
};

/// A liquid of which bubbles rise, for animations: a texture for each time.
ProceduralVolume bubbles(const BubbleOptions& options = {});

struct BushOptions {
  std::uint32_t seed = 1;
  int bushes = 4;                                                   ///< in a period, at least 1
  double growth = 1;                                                ///< 0: bare ground, 1: full-grown
  Vec3 wood_color{0.42, 0.31, 0.22}, leaf_color{0.35, 0.52, 0.20};  ///< sRGB-encoded
};

/// Bushes with leaves, for animations: a texture for each growth. Branches get longer and thicker, and others
/// begin where their ends came by.
ProceduralVolume bushes(const BushOptions& options = {});

}  // namespace recede
