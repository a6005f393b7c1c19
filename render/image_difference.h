// How much two pictures differ.
#pragma once

#include <recede/render/image.h>

#include <span>
#include <vector>

namespace recede {

/// Differences of sRGB-encoded values, where 1 is the step from black to white and 1/255 the smallest step of
/// a usual screen. Values aren't rounded to 8 bits first.
struct ImageDifference {
  int width = 0, height = 0;
  std::vector<float>
      magnitudes;            ///< per pixel, row 0 on top: the largest difference among its three channels
  double rmse = 0;           ///< square root of the mean of all squared channel differences
  double max = 0;            ///< largest of `magnitudes`
  double changed_share = 0;  ///< share of pixels whose magnitude is above 1/255, 0 to 1
};

/// Throws `InputError` when the sizes differ.
ImageDifference compare_images(const Image& a, const Image& b);

/// Colours of heat maps from none to full, evenly spaced on the scale: dark to light, of steadily rising
/// lightness.
std::span<const unsigned> heat_map_colors();

/// Colour of `share` of the full scale; beyond 0..1 it stays at the end.
Rgb heat_map_color(double share);

/// Magnitudes as colours; `full_scale` and more get the lightest. Every pixel shows the largest magnitude of
/// a block of `factor` x `factor` pixels, so that shrinking hides none. Throws `OptionError` unless
/// `full_scale` > 0 and `factor` >= 1.
Image heat_map(const ImageDifference& difference, double full_scale, int factor = 1);

}  // namespace recede
