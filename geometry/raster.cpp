#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/geometry/raster.h>

#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace recede {
namespace {

// libpng reports errors by long jumps unless its handler throws; its C code holds nothing that needs
// unwinding beyond the two structs that PngWriter and PngReader free.
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

struct PngReader {
  png_structp png = nullptr;
  png_infop info = nullptr;
  PngReader() {
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, throw_png_error, ignore_png_warning);
    if (png != nullptr) info = png_create_info_struct(png);
    if (info == nullptr) {
      png_destroy_read_struct(&png, nullptr, nullptr);
      throw Error("PNG: out of memory");
    }
  }
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
};

int color_type_of(int channels) {
  if (channels == 1) return PNG_COLOR_TYPE_GRAY;
  return channels == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_RGB_ALPHA;
}

constexpr const char* k_cut = "the file ends too early";

void take_bytes(png_structp png, png_bytep to, std::size_t count) {
  auto& rest = *static_cast<std::string_view*>(png_get_io_ptr(png));
  if (count > rest.size()) throw Error(k_cut);
  std::memcpy(to, rest.data(), count);
  rest.remove_prefix(count);
}

Raster decode(std::string_view bytes) {
  const std::size_t size = bytes.size();
  // Width and height, behind signature, length and name; libpng only says that something is wrong there.
  constexpr std::string_view k_zero("\0\0\0\0", 4);
  if (size >= 24 && (bytes.substr(16, 4) == k_zero || bytes.substr(20, 4) == k_zero))
    throw Error("there are no pixels");
  const PngReader reader;
  png_set_read_fn(reader.png, &bytes, take_bytes);
  png_read_info(reader.png, reader.info);
  const std::size_t height = png_get_image_height(reader.png, reader.info);
  // Deflate packs at most 1032 bytes into one, so a small file can't ask for all memory.
  constexpr std::size_t k_most_bytes_per_byte = 1032;
  if (png_get_rowbytes(reader.png, reader.info) * height / k_most_bytes_per_byte > size) throw Error(k_cut);
  png_set_expand(reader.png);
  png_set_interlace_handling(reader.png);
  png_read_update_info(reader.png, reader.info);
  Raster raster{.width = static_cast<int>(png_get_image_width(reader.png, reader.info)),
                .height = static_cast<int>(height),
                .channels = png_get_channels(reader.png, reader.info),
                .bits = png_get_bit_depth(reader.png, reader.info),
                .srgb = png_get_valid(reader.png, reader.info, PNG_INFO_sRGB) != 0,
                .samples = {}};
  const std::size_t row_bytes = png_get_rowbytes(reader.png, reader.info);
  std::vector<png_byte> content(row_bytes * height);
  std::vector<png_bytep> rows;
  for (std::size_t y = 0; y < height; ++y) rows.push_back(content.data() + y * row_bytes);
  png_read_image(reader.png, rows.data());
  png_read_end(reader.png, nullptr);
  if (raster.bits == 8) {
    raster.samples.assign(content.begin(), content.end());
    return raster;
  }
  raster.samples.reserve(content.size() / 2);
  for (std::size_t i = 0; i < content.size(); i += 2)
    raster.samples.push_back(static_cast<std::uint16_t>(content[i] << 8 | content[i + 1]));
  return raster;
}

}  // namespace

float encode_srgb(float linear) {
  const float value = std::clamp(linear, 0.0f, 1.0f);
  return value <= 0.0031308f ? 12.92f * value : 1.055f * std::pow(value, 1.0f / 2.4f) - 0.055f;
}

float decode_srgb(float encoded) {
  const float value = std::clamp(encoded, 0.0f, 1.0f);
  return value <= 0.04045f ? value / 12.92f : std::pow((value + 0.055f) / 1.055f, 2.4f);
}

std::string encode_png(const Raster& raster) {
  const auto width = static_cast<std::size_t>(raster.width), height = static_cast<std::size_t>(raster.height);
  const auto channels = static_cast<std::size_t>(raster.channels);
  const bool possible = raster.width > 0 && raster.height > 0 &&
                        (raster.channels == 1 || raster.channels == 3 || raster.channels == 4) &&
                        (raster.bits == 8 || raster.bits == 16);
  if (!possible || raster.samples.size() != width * height * channels) {
    throw OptionError("a raster needs texels of 1, 3 or 4 channels with 8 or 16 bits");
  }
  std::string file;
  const PngWriter writer;
  png_set_write_fn(writer.png, &file, append_bytes, nullptr);
  png_set_IHDR(writer.png, writer.info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height),
               raster.bits, color_type_of(raster.channels), PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
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

Raster decode_png(std::string_view bytes, const std::string& name) {
  try {
    return decode(bytes);
  } catch (const Error& error) {
    throw InputError::in_file(name, error.what());
  }
}

Raster read_png(const std::filesystem::path& path) {
  return decode_png(read_whole_file(path), path.string());
}

}  // namespace recede
