// Smaller versions of volume textures for the distance: as surfaces while these keep their shape, then as
// transparent matter that covers as much.
#pragma once

#include <recede/shells/volume_texture.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

namespace recede {

/// With which a layer of transparent matter is seen as its finest level is.
struct MatterCorrection {
  double density = 1;          ///< factor of -log(1 - opacity)
  Vec3 normal = Vec3::Zero();  ///< what is added to mean normals, in lengths of `VolumeTexture::extent`
  Vec3 color = Vec3::Ones();   ///< factors of colours, linear light: some are hidden more than others
};

/// Rays' directions in lengths of `VolumeTexture::extent`: rows by the angle to the layer, of columns from s
/// on towards t, evenly by angle.
struct MatterDirections {
  static constexpr std::array<double, 14> k_elevations{-90, -67.5, -45, -30, -20, -12,  -5,
                                                       5,   12,    20,  30,  45,  67.5, 90};  ///< degrees
  static constexpr int k_columns = 8;
};

/// A level whose texels let a share of the light through. What lies in a row along an axis hides itself,
/// which each axis knows from the finest level.
struct TransparentVolume {
  std::array<int, 3> size{0, 0, 0};
  /// Share of the rays along s, along t and along r that a texel stops, in 255ths.
  BrickGrid<std::array<std::uint8_t, 3>> opacity{};
  /// How normals are spread: the symmetric matrix Q^-1 of an ellipsoid m' Q m = 1 whose longest axis is 1,
  /// entries 11, 22, 33, 12, 13, 23, -1 to 1 as 0 to 255. In lengths of `VolumeTexture::extent` along s, t,
  /// r.
  BrickGrid<std::array<std::uint8_t, 6>> normals{};
  BrickGrid<std::array<std::uint8_t, 3>> colors{};  ///< sRGB-encoded, as the texture has them
  /// How alike the holes of texels in a row along s, t and r are: 0 not at all, 1 the same.
  Vec3 correlation = Vec3::Zero();
  /// By `MatterDirections`, or none.
  std::vector<MatterCorrection> corrections{};

  /// The texel around a place (s, t, r).
  std::array<int, 3> texel_at(const Vec3& place, bool is_periodic) const {
    std::array<int, 3> cell{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double at = place[static_cast<int>(axis)];
      if (axis < 2 && is_periodic) at -= std::floor(at);
      cell[axis] = std::clamp(static_cast<int>(std::floor(at * size[axis])), 0, size[axis] - 1);
    }
    return cell;
  }
  /// Opacity along a unit direction: that of the axes by the squares of its coordinates.
  double opacity_along(const std::array<int, 3>& texel, const Vec3& direction) const;
  /// Linear between directions, of density the logarithm; `direction` is unit, in lengths of
  /// `VolumeTexture::extent`.
  MatterCorrection correction_along(const Vec3& direction) const;
};

struct MipmapOptions {
  /// The last level of surfaces keeps this share of the finest one's volume, and the inverse at most; 0 to 1.
  double least_share = 0.75;
  /// And it stops as many rays as that, with mean normals as long: a mean over `MatterDirections` of what is
  /// seen differs by no more than this share.
  double seen_tolerance = 0.1;
  /// Half-length of the third axis of the ellipsoid of a flat piece of surface, above 0 and at most 1.
  double flatness = 0.08;
};

/// Sizes halve from level to level, rounded up, until each is 1. Where one is odd, what is behind its middle
/// moves by up to half a texel of the smaller level: powers of two are best.
struct VolumeMipmap {
  std::vector<VolumeTexture> surfaces{};  ///< level 0, 1, ... last
  /// Level `surfaces.size() - 1`, which so is there twice, and those behind it.
  std::vector<TransparentVolume> transparent{};

  int first_transparent() const { return static_cast<int>(surfaces.size()) - 1; }
  int n_levels() const { return first_transparent() + static_cast<int>(transparent.size()); }
};

/// A texture without smaller versions: what is edited, or seen from near only.
std::shared_ptr<const VolumeMipmap> finest_only(VolumeTexture texture);

/// Peng 2004, chapter 6 and appendix B, with three changes: opacity along an axis is that of the finest
/// texels, row by row, instead of pairs of pairs; correlation is fitted to rows of up to four texels; and 64
/// directions of rays through the whole layer are measured at the finest level, which transparent ones are
/// corrected to. Throws `InputError` for a texture that `validate` refuses, `OptionError` for options out of
/// range.
VolumeMipmap make_mipmap(const VolumeTexture& texture, const MipmapOptions& options = {});

/// Of two texels in a row: with a correlation of 0 as if holes were at random, with 1 the larger one; falling
/// between.
double opacity_in_row(double first, double second, double correlation);

/// Q^-1 of normals as bytes, from -1 to 1, and back.
std::array<std::uint8_t, 6> normal_bytes(const Eigen::Matrix3d& matrix);
Eigen::Matrix3d normal_matrix(const std::array<std::uint8_t, 6>& bytes);

/// The mean of the unit normals of an ellipsoid that are seen along a unit direction, from nine places on its
/// outline's disc: the shorter, the more normals differ.
Vec3 mean_normal_along(const Eigen::Matrix3d& inverse, const Vec3& direction);

}  // namespace recede
