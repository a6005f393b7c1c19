#include <recede/geometry/error.h>
#include <recede/render/image_difference.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recede {

namespace {

// Nine stops of matplotlib's "inferno" (van der Walt and Smith 2015, CC0), which is perceptually uniform.
constexpr std::array<unsigned, 9> k_heat{0x000004, 0x210c4a, 0x57106e, 0x8a226a, 0xbc3754,
                                         0xe45a31, 0xf98e09, 0xf9cb35, 0xfcffa4};

// Largest difference that no usual screen shows, with room for the rounding of the encoded floats.
constexpr float k_smallest_step = 1.0f / 255.0f + 1e-6f;

}  // namespace

ImageDifference compare_images(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height)
    throw InputError("images of different sizes can't be compared");
  ImageDifference result{
      .width = a.width, .height = a.height, .magnitudes = std::vector<float>(a.pixels.size())};
  double squares = 0;
  std::size_t changed = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    if (a.pixels[i] == b.pixels[i]) continue;  // most of a background; encoding is the costly part
    for (int channel = 0; channel < 3; ++channel) {
      const float step = std::abs(encode_srgb(a.pixels[i][channel]) - encode_srgb(b.pixels[i][channel]));
      squares += static_cast<double>(step) * static_cast<double>(step);
      result.magnitudes[i] = std::max(result.magnitudes[i], step);
    }
    if (result.magnitudes[i] > k_smallest_step) ++changed;
  }
  const double pixels = static_cast<double>(a.pixels.size());
  if (a.pixels.empty()) return result;
  result.rmse = std::sqrt(squares / (3 * pixels));
  result.max = *std::max_element(result.magnitudes.begin(), result.magnitudes.end());
  result.changed_share = static_cast<double>(changed) / pixels;
  return result;
}

std::span<const unsigned> heat_map_colors() { return k_heat; }

Rgb heat_map_color(double share) {
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(k_heat.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(place), k_heat.size() - 2);
  const float part = static_cast<float>(place - static_cast<double>(below));
  // Mixed as encoded values, as the browser mixes the scale's gradient.
  const Rgb low = rgb_from_hex(k_heat[below]).unaryExpr(&encode_srgb);
  const Rgb high = rgb_from_hex(k_heat[below + 1]).unaryExpr(&encode_srgb);
  return (low + part * (high - low)).unaryExpr(&decode_srgb);
}

Image heat_map(const ImageDifference& difference, double full_scale, int factor) {
  if (!(full_scale > 0) || factor < 1)
    throw OptionError("a heat map needs a scale above 0 and a factor of at least 1");
  Image map((difference.width + factor - 1) / factor, (difference.height + factor - 1) / factor);
  std::vector<float> largest(map.pixels.size(), 0.0f);
  for (int y = 0; y < difference.height; ++y) {
    for (int x = 0; x < difference.width; ++x) {
      float& block = largest[static_cast<std::size_t>(y / factor * map.width + x / factor)];
      block = std::max(block, difference.magnitudes[static_cast<std::size_t>(y * difference.width + x)]);
    }
  }
  std::transform(largest.begin(), largest.end(), map.pixels.begin(), [&](float magnitude) {
    return heat_map_color(static_cast<double>(magnitude) / full_scale);
  });
  return map;
}

}  // namespace recede
