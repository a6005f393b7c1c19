// Trilinear samples of volume textures, for inner loops.
#pragma once

#include <recede/geometry/raster.h>
#include <recede/shells/volume_texture.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace recede::detail {

/// The texel before a place and the one behind it, of `size` along an axis, and the share of the second.
struct VolumeAxis {
  int before, behind;
  double share;

  VolumeAxis(double place, int size, bool is_periodic) {
    const double turns = is_periodic ? place - std::floor(place) : place;
    const double at = std::clamp(turns * size - 0.5, -1.0, static_cast<double>(size));
    const double whole = std::floor(at);
    share = at - whole;
    before = static_cast<int>(whole);
    behind = before + 1;
    if (is_periodic) {
      if (before < 0) before = size - 1;
      if (behind >= size) behind = 0;
      if (before >= size) before = 0;
    } else {
      before = std::clamp(before, 0, size - 1);
      behind = std::clamp(behind, 0, size - 1);
    }
  }
};

/// The eight texels around a place, and how near it is to the later ones.
struct VolumeCell {
  std::array<int, 3> before, behind;
  Vec3 share;

  VolumeCell(const std::array<int, 3>& size, bool is_periodic, const Vec3& place)
      : VolumeCell(VolumeAxis(place.x(), size[0], is_periodic), VolumeAxis(place.y(), size[1], is_periodic),
                   VolumeAxis(place.z(), size[2], false)) {}

  /// Of what `value` makes of texels.
  template <typename Texel, typename Value>
  auto blend(const BrickGrid<Texel>& grid, Value&& value) const {
    // Not what Eigen makes of sums, which refers to what is gone by then.
    using Number = std::decay_t<decltype(value(Texel{}))>;
    const std::array<Texel, 8> texels = grid.corners(before, behind);
    const double u = share.x(), v = share.y(), w = share.z();
    const auto row = [&](std::size_t first) -> Number {
      return (1 - u) * value(texels[first]) + u * value(texels[first + 1]);
    };
    const Number front = (1 - v) * row(0) + v * row(2), back = (1 - v) * row(4) + v * row(6);
    return Number((1 - w) * front + w * back);
  }

 private:
  VolumeCell(const VolumeAxis& s, const VolumeAxis& t, const VolumeAxis& r)
      : before{s.before, t.before, r.before},
        behind{s.behind, t.behind, r.behind},
        share(s.share, t.share, r.share) {}
};

/// 0 to 1.
inline double sampled_opacity(const VolumeTexture& texture, const Vec3& place) {
  const VolumeCell cell(texture.size, texture.is_periodic, place);
  return cell.blend(texture.opacity, [](std::uint8_t opacity) { return static_cast<double>(opacity); }) *
         (1 / 255.0);
}

/// `opacity_gradient` at a texel's middle, from the texels on both sides of it.
inline Vec3 texel_gradient(const VolumeTexture& texture, const std::array<int, 3>& cell) {
  Vec3 gradient;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int size = texture.size[axis];
    std::array<int, 3> before = cell, behind = cell;
    --before[axis];
    ++behind[axis];
    int steps = 2;
    if (axis < 2 && texture.is_periodic) {
      if (before[axis] < 0) before[axis] = size - 1;
      if (behind[axis] >= size) behind[axis] = 0;
    } else {
      before[axis] = std::max(before[axis], 0);
      behind[axis] = std::min(behind[axis], size - 1);
      steps = behind[axis] - before[axis];
    }
    const int rise = texture.opacity.at(behind) - texture.opacity.at(before);
    gradient[static_cast<int>(axis)] = steps > 0 ? rise / 255.0 * size / steps : 0;
  }
  return gradient;
}

inline Vec3 linear_color(const Vec3& bytes) {
  return bytes.unaryExpr(
      [](double byte) { return static_cast<double>(decode_srgb(static_cast<float>(byte) / 255.0f)); });
}

/// The same of one channel, by its byte.
inline const std::array<double, 256>& linear_of_bytes() {
  static const std::array<double, 256> numbers = [] {
    std::array<double, 256> made{};
    for (std::size_t byte = 0; byte < made.size(); ++byte)
      made[byte] = static_cast<double>(decode_srgb(static_cast<float>(byte) / 255.0f));
    return made;
  }();
  return numbers;
}

inline Vec3 number_of(const std::array<std::uint8_t, 3>& bytes) {
  return {static_cast<double>(bytes[0]), static_cast<double>(bytes[1]), static_cast<double>(bytes[2])};
}

/// Linear light; there must be colours. Between texels what is encoded is blended.
inline Vec3 sampled_color(const VolumeTexture& texture, const Vec3& place) {
  const VolumeCell cell(texture.size, texture.is_periodic, place);
  return linear_color(cell.blend(texture.colors, number_of));
}

/// Opacity in and around a surface, from the signed distance, above 0 inside: 0 to 1 over twice the ramp.
inline double ramped_opacity(double distance, double ramp) {
  return std::clamp(0.5 + distance / (2 * ramp), 0.0, 1.0);
}
inline std::uint8_t opacity_byte(double opacity) { return static_cast<std::uint8_t>(255 * opacity + 0.5); }

/// Clamped to 0 to 1.
inline std::uint8_t byte_of(double share) { return opacity_byte(std::clamp(share, 0.0, 1.0)); }

/// Of encoded channels, clamped to 0 to 1.
inline std::array<std::uint8_t, 3> color_bytes(const Vec3& color) {
  return {byte_of(color.x()), byte_of(color.y()), byte_of(color.z())};
}

}  // namespace recede::detail
