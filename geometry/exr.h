// Pictures of floating-point samples with named channels, and OpenEXR files of them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace recede {

/// A rectangle of texels, row by row, row 0 on top.
struct FloatRaster {
  int width = 0, height = 0;
  /// Names as OpenEXR has them: R, G, B, A for colours, Y for grey, Z for depth, or any others.
  std::vector<std::string> channels;
  std::vector<float> samples;  ///< height x width x channels

  float at(int x, int y, std::size_t channel = 0) const {
    return samples[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                    static_cast<std::size_t>(x)) *
                       channels.size() +
                   channel];
  }
  bool operator==(const FloatRaster&) const = default;
};

struct ExrOptions {
  bool half = false;     ///< 16 bits a sample, of which 11 count, up to 65504; else 32 bits, kept bit for bit
  std::string comments;  ///< what the samples mean: the attribute `comments` of the file
};

/// The bytes of an OpenEXR file: scan lines in one part, compressed without loss (ZIP). Same samples, same
/// bytes. Throws `OptionError` unless there are texels, channels with different names, and samples for them,
/// and `Error` with OpenEXR's reason.
std::string encode_exr(const FloatRaster& raster, const ExrOptions& options = {});

/// What the bytes of an OpenEXR file hold, numbers of any kind as floats, the data window only. R, G, B and A
/// come first, then the other channels by name. Throws `InputError` with `name` in front for anything else,
/// deep and subsampled pictures included.
FloatRaster decode_exr(std::string_view bytes, const std::string& name);

/// `decode_exr` of a whole file.
FloatRaster read_exr(const std::filesystem::path& path);

}  // namespace recede
