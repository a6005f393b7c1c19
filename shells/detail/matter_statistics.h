// What transparent levels of volume textures are made of.
#pragma once

#include <recede/shells/volume_mipmap.h>

#include <Eigen/Core>

namespace recede::detail {

/// Share of a texel that is inside, if the surface is flat across it, by its opacity.
using CoverageOfOpacity = std::array<float, 256>;
CoverageOfOpacity coverage_of_opacity(const VolumeTexture& texture);

/// What texels of a level know of the finest one, from level to level. Shares that are inside follow from
/// opacity, which so is all that is kept of them: the largest in rows along each axis, in bricks. Of normals,
/// sums are kept from the second level on: where the surface is, 72 bytes for 64 texels. What is between is
/// made anew when it is asked for.
class MatterStatistics {
 public:
  /// Those of the finest level, which must stay.
  MatterStatistics(const VolumeTexture& finest, double flatness);

  /// Goes on to the next, smaller level.
  void halve();

  const std::array<int, 3>& size() const { return size_; }
  /// As `TransparentVolume` has them.
  BrickGrid<std::array<std::uint8_t, 3>> opacity() const;
  BrickGrid<std::array<std::uint8_t, 6>> normals() const;
  /// With which rows of up to four texels along an axis stop as much as the finest texels say: least squares,
  /// since opacity is linear in it.
  double correlation(std::size_t axis) const;

 private:
  using Matrix3 = Eigen::Matrix3d;
  using Sum = std::array<double, 9>;

  class Means;
  Matrix3 flat_piece(const std::array<int, 3>& cell) const;
  Matrix3 sum_of_children(int level, const std::array<int, 3>& cell) const;
  bool has_surface(const TexelBox& box) const;

  const VolumeTexture& finest_;
  double flatness_;
  CoverageOfOpacity coverage_;
  int level_ = 0;
  std::array<int, 3> size_;
  std::array<BrickGrid<std::uint8_t>, 3>
      rows_;                // by axis: the largest opacity in a row, halved along it alone
  BrickGrid<Sum> normals_;  // from the second level on
};

/// Half as many texels along each axis, rounded up.
inline std::array<int, 3> half(const std::array<int, 3>& size) {
  return {(size[0] + 1) / 2, (size[1] + 1) / 2, (size[2] + 1) / 2};
}

/// The texels of the next finer level that a box of texels is made of.
inline TexelBox children_of(const TexelBox& box, const std::array<int, 3>& fine) {
  TexelBox children;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    children.first[axis] = 2 * box.first[axis];
    children.last[axis] = std::min(2 * box.last[axis], fine[axis]);
  }
  return children;
}

}  // namespace recede::detail
