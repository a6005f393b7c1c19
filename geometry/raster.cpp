#include <recede/geometry/error.h>
#include <recede/geometry/raster.h>

#include <png.h>

namespace recede {
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

std::string encode_png(const Raster& raster) {
  const auto width = static_cast<std::size_t>(raster.width), height = static_cast<std::size_t>(raster.height);
  const auto channels = static_cast<std::size_t>(raster.channels);
  const bool possible = raster.width > 0 && raster.height > 0 &&
                        (raster.channels == 1 || raster.channels == 3) &&
                        (raster.bits == 8 || raster.bits == 16);
  if (!possible || raster.samples.size() != width * height * channels) {
    throw OptionError("a raster needs texels of 1 or 3 channels with 8 or 16 bits");
  }
  std::string file;
  const PngWriter writer;
  png_set_write_fn(writer.png, &file, append_bytes, nullptr);
  png_set_IHDR(writer.png, writer.info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height),
               raster.bits, channels == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (raster.srgb) png_set_sRGB(writer.png, writer.info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_write_info(writer.png, writer.info);
  const std::size_t row_samples = width * channels;
  std::vector<png_byte> row;
  for (std::size_t y = 0; y < height; ++y) {
    row.clear();
    for (std::size_t i = y * row_samples; i < (y + 1) * row_samples; ++i) {
      if (raster.bits == 16) row.push_back(static_cast<png_byte>(raster.samples[i] >> 8));
      row.push_back(static_cast<png_byte>(raster.samples[i] & 0xff));
    }
    png_write_row(writer.png, row.data());
  }
  png_write_end(writer.png, writer.info);
  return file;
}

}  // namespace recede
