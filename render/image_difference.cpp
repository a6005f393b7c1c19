#include <recede/geometry/error.h>
#include <recede/render/detail/image_pair.h>

#include <fmt/format.h>

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

namespace detail {

void require_comparable(const Image& a, const Image& b, const ImageMask& mask) {
  if (a.width != b.width || a.height != b.height) {
    throw InputError(fmt::format("images of different sizes can't be compared: {} x {} and {} x {} pixels",
                                 a.width, a.height, b.width, b.height));
  }
  if (mask.inside.empty()) {
    if (a.pixels.empty()) throw InputError("images without pixels can't be compared");
    return;
  }
  if (mask.width != a.width || mask.height != a.height || mask.inside.size() != a.pixels.size()) {
    throw InputError(fmt::format("the mask has {} x {} pixels, the images {} x {}", mask.width, mask.height,
                                 a.width, a.height));
  }
  if (std::find(mask.inside.begin(), mask.inside.end(), 1) == mask.inside.end())
    throw InputError("the mask leaves no pixel");
}

FloatRaster empty_map(const Image& image, float fill) {
  return {image.width, image.height, {"Y"}, std::vector<float>(image.pixels.size(), fill)};
}

std::optional<double> mean_inside(const FloatRaster& map, const ImageMask& mask, int frame) {
  double sum = 0;
  std::size_t counted = 0;
  for (int y = frame; y < map.height - frame; ++y) {
    for (int x = frame; x < map.width - frame; ++x) {
      const auto i =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width) + static_cast<std::size_t>(x);
      if (!mask.counts(i)) continue;
      sum += static_cast<double>(map.samples[i]);
      ++counted;
    }
  }
  if (counted == 0) return std::nullopt;
  return sum / static_cast<double>(counted);
}

double luma(const Rgb& linear) {
  const Rgb encoded = linear.unaryExpr(&encode_srgb);
  return Eigen::Vector3d(0.299, 0.587, 0.114).dot(encoded.cast<double>());
}

}  // namespace detail

ImageMask mask_of(const Image& image) {
  ImageMask mask{image.width, image.height, {}};
  mask.inside.reserve(image.pixels.size());
  for (const Rgb& pixel : image.pixels) mask.inside.push_back(detail::luma(pixel) > 0.5 ? 1 : 0);
  return mask;
}

ImageDifference compare_images(const Image& a, const Image& b, const ImageMask& mask) {
  detail::require_comparable(a, b, mask);
  ImageDifference result{.magnitudes = detail::empty_map(a, 0)};
  double squares = 0;
  std::size_t changed = 0, counted = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    if (!mask.counts(i)) continue;
    ++counted;
    if (a.pixels[i] == b.pixels[i]) continue;  // most of a background; encoding is the costly part
    float& magnitude = result.magnitudes.samples[i];
    for (int channel = 0; channel < 3; ++channel) {
      const float step = std::abs(encode_srgb(a.pixels[i][channel]) - encode_srgb(b.pixels[i][channel]));
      squares += static_cast<double>(step) * static_cast<double>(step);
      magnitude = std::max(magnitude, step);
    }
    result.max = std::max(result.max, static_cast<double>(magnitude));
    if (magnitude > k_smallest_step) ++changed;
  }
  result.rmse = std::sqrt(squares / (3 * static_cast<double>(counted)));
  result.psnr = 0 - 20 * std::log10(result.rmse);  // 0, not -0, for black and white
  result.changed_share = static_cast<double>(changed) / static_cast<double>(counted);
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

Image heat_map(const FloatRaster& values, double full_scale, int factor) {
  if (!(full_scale > 0) || factor < 1)
    throw OptionError("a heat map needs a scale above 0 and a factor of at least 1");
  factor = std::min(factor, std::max({1, values.width, values.height}));  // beyond, all is one block
  Image map((values.width + factor - 1) / factor, (values.height + factor - 1) / factor);
  std::vector<float> largest(map.pixels.size(), 0.0f);
  for (int y = 0; y < values.height; ++y) {
    for (int x = 0; x < values.width; ++x) {
      float& block = largest[static_cast<std::size_t>(y / factor * map.width + x / factor)];
      block = std::max(block, values.at(x, y));
    }
  }
  std::transform(largest.begin(), largest.end(), map.pixels.begin(), [&](float magnitude) {
    return heat_map_color(static_cast<double>(magnitude) / full_scale);
  });
  return map;
}

}  // namespace recede
