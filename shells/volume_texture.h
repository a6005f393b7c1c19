// Volume textures: grids of opacity that fill shells with detail of any topology, as weave, bark or chain
// mail.
//
// Peng 2004, "Thick Surfaces", section 3.3 and chapter 5. Gradients aren't stored: they follow from the
// opacity.
#pragma once

#include <recede/geometry/progress.h>
#include <recede/geometry/vec.h>
#include <recede/shells/brick_grid.h>

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace recede {

/// Places in it are (s, t, r): s and t count periods, r goes from 0 at a shell's surface to 1 at its tops.
/// Texel (i, j, k) has its middle at ((i + 1/2) / size[0], (j + 1/2) / size[1], (k + 1/2) / size[2]).
struct VolumeTexture {
  std::array<int, 3> size{0, 0, 0};  ///< texels along s, t and r, each at least 1
  /// What it shows is where opacity is a half and more, in 255ths: 0 outside, 255 inside.
  BrickGrid<std::uint8_t> opacity{};
  BrickGrid<std::array<std::uint8_t, 3>> colors{};  ///< sRGB-encoded, of each texel; or none
  bool is_periodic = true;                          ///< along s and t; else it goes on as at its borders
  Vec3 extent = Vec3::Ones();                       ///< lengths of a period along s, t and r, in one unit
  /// Opacity goes from 0 to 1 over twice this length around the surface, in the same unit. 0: unknown.
  double ramp = 0;

  std::size_t n_texels() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
           static_cast<std::size_t>(size[2]);
  }
  /// Number of a texel in lists of all: s runs fastest, then t, then r.
  std::size_t texel(int i, int j, int k) const {
    return static_cast<std::size_t>(i) +
           static_cast<std::size_t>(size[0]) *
               (static_cast<std::size_t>(j) +
                static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(k));
  }
  /// (s, t, r) of a texel's middle.
  Vec3 middle(int i, int j, int k) const {
    return {(i + 0.5) / size[0], (j + 0.5) / size[1], (k + 0.5) / size[2]};
  }
};

/// Throws `InputError`, with `source` in front, for sizes below 1, grids of other sizes than these, and
/// lengths that aren't finite and above 0.
void validate(const VolumeTexture& texture, const std::string& source);

/// Linear between texels' middles, 0 to 1; beyond the outermost along r as there.
double opacity_at(const VolumeTexture& texture, const Vec3& place);

/// Change of opacity for a step of 1 in s, t and r: from differences over two texels, linear between texels'
/// middles, so that normals have no steps.
Vec3 opacity_gradient(const VolumeTexture& texture, const Vec3& place);

/// Signed distance from the surface of what a texture shows, above 0 inside, at a point in the unit of
/// `VolumeOptions::extent`. Called from several threads.
using InsideDistance = std::function<double(const Vec3& point)>;

struct VolumeOptions {
  std::array<int, 3> size{64, 64, 16};  ///< texels along s, t and r, each at least 1
  /// Lengths along s, t and r. Points go from 0 to these.
  Vec3 extent{1, 1, 0.25};
  bool is_periodic = true;  ///< the function should be, along s and t
  /// Half of the width over which opacity goes from 0 to 1, in the longest sides of texels: 2 lets gradients
  /// see both sides.
  double ramp_texels = 2;
  /// sRGB-encoded colour at a point, 0 to 1 in each channel.
  std::function<Vec3(const Vec3& point)> color{};
};

/// Samples a function at all texels' middles: opacity is 1/2 + distance / (2 ramp), from 0 to 1. Throws
/// `OptionError` for sizes, lengths or ramps out of range or more than `k_most_texels`, `InputError` for a
/// distance that isn't a number (it names the texel), and `Cancelled`.
VolumeTexture make_volume(const InsideDistance& inside, const VolumeOptions& options,
                          Progress* progress = nullptr);

/// 2 GiB of opacity.
inline constexpr std::size_t k_most_texels = std::size_t{1} << 31;

/// Throws `OptionError` for sizes below 1 and more texels than `k_most_texels`.
void check_texels(const std::array<int, 3>& size);

}  // namespace recede
