#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/geometry/raster.h>
#include <recede/render/image.h>

#include <algorithm>
#include <cmath>

namespace recede {

Image::Image(int image_width, int image_height, const Rgb& fill) : width(image_width), height(image_height) {
  if (width < 1 || height < 1) throw OptionError("an image needs at least one pixel a side");
  pixels.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), fill);
}

Rgb rgb_from_hex(unsigned hex) {
  const auto channel = [hex](unsigned shift) {
    return decode_srgb(static_cast<float>((hex >> shift) & 0xffu) / 255.0f);
  };
  return {channel(16), channel(8), channel(0)};
}

Image shrink(const Image& image, int factor) {
  if (factor < 1) throw OptionError("an image shrinks by a factor of at least 1");
  factor = std::min(factor, std::max({1, image.width, image.height}));  // beyond, all is one block
  Image small((image.width + factor - 1) / factor, (image.height + factor - 1) / factor);
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      const int right = std::min(image.width, (x + 1) * factor),
                below = std::min(image.height, (y + 1) * factor);
      Rgb sum = Rgb::Zero();
      for (int from_y = y * factor; from_y < below; ++from_y) {
        for (int from_x = x * factor; from_x < right; ++from_x) sum += image.at(from_x, from_y);
      }
      small.at(x, y) = sum / static_cast<float>((right - x * factor) * (below - y * factor));
    }
  }
  return small;
}

Image side_by_side(std::span<const Image> images) {
  int width = 0, height = 0;
  for (const Image& image : images) {
    width += image.width;
    height = std::max(height, image.height);
  }
  Image all(width, height, Rgb::Ones());
  int left = 0;
  for (const Image& image : images) {
    const int above = (height - image.height) / 2;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) all.at(left + x, above + y) = image.at(x, y);
    }
    left += image.width;
  }
  return all;
}

std::string encode_png(const Image& image) {
  Raster raster{.width = image.width, .height = image.height, .channels = 3, .srgb = true, .samples = {}};
  raster.samples.reserve(3 * image.pixels.size());
  for (const Rgb& pixel : image.pixels) {
    for (const float channel : pixel) {
      raster.samples.push_back(static_cast<std::uint16_t>(std::lround(255.0f * encode_srgb(channel))));
    }
  }
  return encode_png(raster);
}

void write_png(const std::filesystem::path& path, const Image& image) {
  write_file_atomically(path, encode_png(image));
}

}  // namespace recede
