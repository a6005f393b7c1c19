// What a ray passes of transparent matter.
#pragma once

#include <recede/shells/volume_mipmap.h>

#include <algorithm>
#include <cmath>

namespace recede::detail {

/// Of a texel, by its opacities along the axes, in 255ths.
inline double opacity_along(const std::array<std::uint8_t, 3>& along_axes, const Vec3& direction) {
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double along = direction[static_cast<int>(axis)];
    sum += along * along * along_axes[axis];
  }
  return sum / 255;
}

/// Opacity along a ray, gathered step by step.
class MatterPath {
 public:
  static constexpr double k_step = 0.25;  ///< of a texel, at most

  MatterPath(const TransparentVolume& matter, const VolumeTexture& finest)
      : matter_(matter), finest_(finest) {}

  /// `middle` is the place in the step's middle, `move` how far the place moves in the whole step. Returns
  /// what share of such rays was stopped so far.
  double advance(const Vec3& middle, const Vec3& move) {
    const std::array<int, 3> texel = matter_.texel_at(middle, finest_.is_periodic);
    const Vec3 size(matter_.size[0], matter_.size[1], matter_.size[2]);
    const double texels = move.cwiseProduct(size).norm();
    direction_ = move.cwiseProduct(finest_.extent).stableNormalized();
    // A ray that just touches a texel isn't stopped as one across all of it, not even by a closed one.
    constexpr double k_most_opacity = 0.98;
    if (texel != texel_) {
      in_texel_ = 0;
      texel_ = texel;
      along_axes_ = matter_.opacity.at(texel);
    }
    const double opacity = std::min(opacity_along(along_axes_, direction_), k_most_opacity);
    in_texel_ += texels;
    open_ *= std::pow(1 - opacity, texels);
    densest_ = std::max(densest_, 1 - std::pow(1 - opacity, in_texel_));
    // Rows are alike along an axis; beside it a ray soon is in others.
    const double correlation =
        direction_.array().square().square().square().matrix().dot(matter_.correlation);
    return (1 - correlation) * (1 - open_) + correlation * densest_;
  }

  const std::array<int, 3>& texel() const { return texel_; }
  /// Of the last step, unit, in lengths of the texture's extent.
  const Vec3& direction() const { return direction_; }

 private:
  const TransparentVolume& matter_;
  const VolumeTexture& finest_;
  double open_ = 1, densest_ = 0, in_texel_ = 0;
  std::array<int, 3> texel_{-1, -1, -1};
  std::array<std::uint8_t, 3> along_axes_{};
  Vec3 direction_ = Vec3::UnitZ();
};

}  // namespace recede::detail
