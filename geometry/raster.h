// Samples on a grid, as picture files hold them: PNG files are read and written, JPEG files read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace recede {

/// A rectangle of texels, row by row, row 0 on top. Samples are whole numbers from 0 to 2^bits - 1.
struct Raster {
  int width = 0, height = 0;
  int channels = 1;   ///< 1: grey, 3: red, green, blue, 4: with opacity; files may also have 2
  int bits = 8;       ///< of a sample, 8 or 16
  bool srgb = false;  ///< samples are encoded by the sRGB transfer function; else linear data
  std::vector<std::uint16_t> samples;  ///< height x width x channels

  std::uint16_t at(int x, int y, int channel = 0) const {
    return samples[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                    static_cast<std::size_t>(x)) *
                       static_cast<std::size_t>(channels) +
                   static_cast<std::size_t>(channel)];
  }
  bool operator==(const Raster&) const = default;
};

/// The sRGB transfer function: linear light, clamped to 0..1, to the encoded value in 0..1.
float encode_srgb(float linear);
/// Its inverse.
float decode_srgb(float encoded);

/// The bytes of a PNG file with the same samples. A raster that isn't sRGB says nothing about its transfer
/// function. Throws `OptionError` unless sizes and bits are as said above, there are 1, 3 or 4 channels,
/// and samples for them, and `Error` with libpng's reason.
std::string encode_png(const Raster& raster);

/// What the bytes of a PNG file hold, of any kind: palettes become colours, samples of fewer than 8 bits are
/// spread over 8, transparent colours become a channel of opacity. `srgb` says whether the file has the chunk
/// of that name. Throws `InputError` with `name` in front for anything else.
Raster decode_png(std::string_view bytes, const std::string& name);

/// What the bytes of a JPEG file hold: grey, or red, green and blue, 8 bits, encoded by sRGB. Throws
/// `InputError` with `name` in front for anything else, files that are cut short or damaged, and those in
/// print colours.
Raster decode_jpeg(std::string_view bytes, const std::string& name);

enum class PictureFormat { png, jpeg, unknown };
/// By the file's first bytes.
PictureFormat picture_format(std::string_view bytes);
/// A PNG or a JPEG file. Throws `InputError` with `name` in front for others.
Raster decode_picture(std::string_view bytes, const std::string& name);

/// `decode_png` of a whole file.
Raster read_png(const std::filesystem::path& path);

}  // namespace recede
