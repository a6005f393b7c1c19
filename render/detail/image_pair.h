// What the measures of two images share.
#pragma once

#include <recede/render/detail/plane_filter.h>
#include <recede/render/image_difference.h>

#include <optional>
#include <vector>

namespace recede::detail {

/// Throws `InputError` unless images and mask have one size and some pixel counts.
void require_comparable(const Image& a, const Image& b, const ImageMask& mask);

inline PlaneSize size_of(const Image& image) { return {image.width, image.height}; }

/// A map of the image's size.
FloatRaster empty_map(const Image& image, float fill);

/// Mean over the pixels that count and don't lie in a frame of so many pixels. Nothing when there are none.
std::optional<double> mean_inside(const FloatRaster& map, const ImageMask& mask, int frame = 0);

/// Of sRGB-encoded values, with the weights of ITU-R BT.601.
double luma(const Rgb& linear);

/// 1 where a pixel counts, else 0; empty for the mask of all pixels.
template <typename Number>
std::vector<Number> weights_of(const ImageMask& mask) {
  return {mask.inside.begin(), mask.inside.end()};
}

/// Takes away what doesn't count.
template <typename Number>
void apply_weights(const std::vector<Number>& weights, std::vector<Number>& plane) {
  for (std::size_t i = 0; i < weights.size(); ++i) plane[i] *= weights[i];
}

}  // namespace recede::detail
