// Where a volume texture holds nothing that rays could meet.
#pragma once

#include <recede/shells/volume_texture.h>

#include <vector>

namespace recede::detail {

/// Cubes of a texture's cells, between texels' middles, in and around which opacity is below a half.
class EmptyRegions {
 public:
  explicit EmptyRegions(const VolumeTexture& texture);

  /// How long a place that moves this much for a length of 1 stays in an empty cube; 0 in others. Where the
  /// way isn't quite straight, there is nothing either as far as `k_margin` texels beside the cube.
  double free_length(const Vec3& place, const Vec3& move) const;

 private:
  static constexpr int k_side = 8;    // cells
  static constexpr int k_margin = 2;  // texels: a quarter of the way

  void mark(const TexelBox& box);
  std::size_t number(int i, int j, int k) const {
    return static_cast<std::size_t>(i) +
           static_cast<std::size_t>(counts_[0]) *
               (static_cast<std::size_t>(j) +
                static_cast<std::size_t>(counts_[1]) * static_cast<std::size_t>(k));
  }

  std::array<int, 3> size_, counts_;
  bool is_periodic_;
  std::vector<std::uint8_t> is_empty_;
};

}  // namespace recede::detail
