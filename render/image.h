// Pictures in linear light, and PNG files of them.
#pragma once

#include <recede/geometry/raster.h>

#include <Eigen/Core>

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace recede {

/// Linear red, green and blue (sRGB primaries); 1 is the white of a screen.
using Rgb = Eigen::Vector3f;

/// A rectangle of pixels, row by row, row 0 on top.
struct Image {
  Image() = default;
  /// All pixels `fill`. Throws `OptionError` unless both sides are at least one pixel.
  Image(int image_width, int image_height, const Rgb& fill = Rgb::Zero());

  int width = 0;
  int height = 0;
  std::vector<Rgb> pixels;

  const Rgb& at(int x, int y) const { return pixels[index(x, y)]; }
  Rgb& at(int x, int y) { return pixels[index(x, y)]; }

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

/// The linear colour that web pages write as 0xrrggbb.
Rgb rgb_from_hex(unsigned hex);

/// Means (in linear light) over blocks of `factor` x `factor` pixels; blocks at the right and lower border
/// may be smaller. Throws `OptionError` for a factor below 1.
Image shrink(const Image& image, int factor);

/// One picture of all, from left to right without gaps, as high as the highest. Lower ones stand in the
/// middle of that height, with white above and below. Throws `OptionError` when there are none.
Image side_by_side(std::span<const Image> images);

/// The bytes of a PNG file: 8 bits a channel, sRGB. Throws `Error` with libpng's reason.
std::string encode_png(const Image& image);

/// Writes `encode_png(image)`; no half-written file is ever seen. Throws `InputError` when the file can't be
/// written.
void write_png(const std::filesystem::path& path, const Image& image);

}  // namespace recede
