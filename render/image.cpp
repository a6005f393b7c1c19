#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/render/image.h>

#include <png.h>

#include <algorithm>
#include <cmath>

namespace recede {

Image::Image(int image_width, int image_height, const Rgb& fill) : width(image_width), height(image_height) {
  if (width < 1 || height < 1) throw OptionError("an image needs at least one pixel a side");
  pixels.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), fill);
}

float encode_srgb(float linear) {
  const float value = std::clamp(linear, 0.0f, 1.0f);
  return value <= 0.0031308f ? 12.92f * value : 1.055f * std::pow(value, 1.0f / 2.4f) - 0.055f;
}

float decode_srgb(float encoded) {
  const float value = std::clamp(encoded, 0.0f, 1.0f);
  return value <= 0.04045f ? value / 12.92f : std::pow((value + 0.055f) / 1.055f, 2.4f);
}

Rgb rgb_from_hex(unsigned hex) {
  const auto channel = [hex](unsigned shift) {
    return decode_srgb(static_cast<float>((hex >> shift) & 0xffu) / 255.0f);
  };
  return {channel(16), channel(8), channel(0)};
}

Image shrink(const Image& image, int factor) {
  if (factor < 1) throw OptionError("an image shrinks by a factor of at least 1");
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

namespace {

// libpng reports errors by long jumps unless its handler throws; its C code holds nothing that needs
// unwinding beyond the two structs that PngWriter frees.
[[noreturn]] void throw_png_error(png_structp, png_const_charp reason) {
  throw Error(std::string("PNG: ") + reason);
}

void ignore_png_warning(png_structp, png_const_charp) {}

void append_bytes(png_structp png, png_bytep bytes, std::size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), count);
}

struct PngWriter {
  png_structp png = nullptr;
  png_infop info = nullptr;
  PngWriter() {
    png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, throw_png_error, ignore_png_warning);
    if (png != nullptr) info = png_create_info_struct(png);
    if (info == nullptr) {
      png_destroy_write_struct(&png, nullptr);
      throw Error("PNG: out of memory");
    }
  }
  ~PngWriter() { png_destroy_write_struct(&png, &info); }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;
};

}  // namespace

std::string encode_png(const Image& image) {
  std::string file;
  const PngWriter writer;
  png_set_write_fn(writer.png, &file, append_bytes, nullptr);
  png_set_IHDR(writer.png, writer.info, static_cast<png_uint_32>(image.width),
               static_cast<png_uint_32>(image.height), 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(writer.png, writer.info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_write_info(writer.png, writer.info);
  std::vector<png_byte> row(static_cast<std::size_t>(image.width) * 3);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int channel = 0; channel < 3; ++channel) {
        const float encoded = encode_srgb(image.at(x, y)[channel]);
        row[static_cast<std::size_t>(3 * x + channel)] = static_cast<png_byte>(std::lround(255.0f * encoded));
      }
    }
    png_write_row(writer.png, row.data());
  }
  png_write_end(writer.png, writer.info);
  return file;
}

void write_png(const std::filesystem::path& path, const Image& image) {
  write_file_atomically(path, encode_png(image));
}

}  // namespace recede
