// How much two pictures differ: by numbers, by structure, and to the eye.
#pragma once

#include <recede/geometry/exr.h>
#include <recede/render/image.h>

#include <cstdint>
#include <span>
#include <vector>

namespace recede {

/// The pixels that count, all of them when it is empty. What lies outside changes no measure, not even near
/// the mask's border.
struct ImageMask {
  int width = 0, height = 0;
  std::vector<std::uint8_t> inside;  ///< 1 or 0 per pixel, row 0 on top

  bool counts(std::size_t pixel) const { return inside.empty() || inside[pixel] != 0; }
};

/// The pixels whose sRGB-encoded grey is above 0.5: in a PNG file of 8 bits, from 128 on.
ImageMask mask_of(const Image& image);

/// Differences of sRGB-encoded values, where 1 is the step from black to white and 1/255 the smallest step of
/// a usual screen. Values aren't rounded to 8 bits first.
struct ImageDifference {
  /// Per pixel the largest difference among its three channels; 0 outside the mask.
  FloatRaster magnitudes;
  double rmse = 0;           ///< square root of the mean of all squared channel differences
  double psnr = 0;           ///< peak signal-to-noise ratio, -20 log10(rmse), dB; infinite for equal images
  double max = 0;            ///< largest of `magnitudes`
  double changed_share = 0;  ///< share of pixels whose magnitude is above 1/255, 0 to 1
};

/// Throws `InputError` when the sizes differ or no pixel counts, as all measures do. Pixels must be finite.
ImageDifference compare_images(const Image& a, const Image& b, const ImageMask& mask = {});

/// A measure of every pixel, and its mean.
struct ImageMeasure {
  double mean = 0;
  FloatRaster map;  ///< one channel
};

/// The structural similarity index of luma (Wang et al. 2004, "Image quality assessment: from error
/// visibility to structural similarity", equation 13): 1 for equal neighbourhoods, down to -1. The window is
/// Gaussian, 11 x 11 pixels, sigma 1.5; K1 = 0.01, K2 = 0.03. Luma is that of sRGB-encoded values (ITU-R
/// BT.601). As in the authors' program the mean leaves out pixels whose window reaches over the image's
/// border, unless there are no others; the map has them. Windows see only what is inside the mask; the map is
/// 1 outside.
ImageMeasure compute_ssim(const Image& a, const Image& b, const ImageMask& mask = {});

struct FlipOptions {
  /// Pixels that one degree of the viewer's field of view covers, 1 to 1000. The default is that of the
  /// paper: a screen of 3840 pixels, 0.7 m wide, from 0.7 m away.
  double pixels_per_degree = 67.02;
};

/// The difference that one sees when the images alternate in place: FLIP (Andersson et al. 2020, "FLIP: a
/// difference evaluator for alternating images") of pictures for a screen, with the paper's constants. 0 for
/// equal images; the largest, 1, lies between full green and full blue; black and white are 0.967 apart.
/// Linear values are clamped to 0..1. Filters see only what is inside the mask; the map is 0 outside. Throws
/// `OptionError` for pixels per degree out of range.
ImageMeasure compute_flip(const Image& a, const Image& b, const FlipOptions& options = {},
                          const ImageMask& mask = {});

/// Colours of heat maps from none to full, evenly spaced on the scale: dark to light, of steadily rising
/// lightness.
std::span<const unsigned> heat_map_colors();

/// Colour of `share` of the full scale; beyond 0..1 it stays at the end.
Rgb heat_map_color(double share);

/// The values of a map as colours; `full_scale` and more get the lightest. Every pixel shows the largest
/// value of a block of `factor` x `factor` pixels, so that shrinking hides none. Throws `OptionError` unless
/// `full_scale` > 0 and `factor` >= 1.
Image heat_map(const FloatRaster& map, double full_scale, int factor = 1);

}  // namespace recede
