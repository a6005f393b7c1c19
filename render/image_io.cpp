#include <recede/geometry/atomic_file.h>
#include <recede/geometry/detail/format_io.h>
#include <recede/geometry/error.h>
#include <recede/render/image_io.h>

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace recede {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view k_png_signature = "\x89PNG\r\n\x1a\n"sv;
constexpr std::string_view k_exr_signature = "\x76\x2f\x31\x01"sv;

/// Linear light of every sample.
std::vector<float> decoding_table(int bits) {
  std::vector<float> table(std::size_t{1} << bits);
  const float largest = static_cast<float>(table.size() - 1);
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = decode_srgb(static_cast<float>(i) / largest);
  return table;
}

/// Where `name` is among the channels, or their number.
std::size_t place_of(const FloatRaster& raster, std::string_view name) {
  return static_cast<std::size_t>(std::find(raster.channels.begin(), raster.channels.end(), name) -
                                  raster.channels.begin());
}

Image decode_image(std::string_view bytes, const std::string& name) {
  if (bytes.starts_with(k_png_signature)) return to_image(decode_png(bytes, name));
  if (!bytes.starts_with(k_exr_signature))
    throw InputError::in_file(name, "is neither a PNG nor an OpenEXR picture");
  const FloatRaster raster = decode_exr(bytes, name);
  try {
    return to_image(raster);
  } catch (const InputError& error) {
    throw InputError::in_file(name, error.what());
  }
}

}  // namespace

Image to_image(const Raster& raster) {
  Image image(raster.width, raster.height);
  const std::vector<float> light = decoding_table(raster.bits);
  const auto channels = static_cast<std::size_t>(raster.channels);
  const std::size_t step = channels >= 3 ? 1 : 0;  // grey: one sample for all three
  const bool opaque = channels % 2 == 1;
  const float largest = static_cast<float>(light.size() - 1);
  const std::uint16_t* sample = raster.samples.data();
  for (Rgb& pixel : image.pixels) {
    pixel = Rgb(light[sample[0]], light[sample[step]], light[sample[2 * step]]);
    if (!opaque) {
      const float opacity = static_cast<float>(sample[channels - 1]) / largest;
      pixel = opacity * pixel + Rgb::Constant(1 - opacity);
    }
    sample += channels;
  }
  return image;
}

Image to_image(const FloatRaster& raster) {
  const std::size_t n = raster.channels.size();
  std::size_t red = place_of(raster, "R"), green = place_of(raster, "G"), blue = place_of(raster, "B");
  const std::size_t grey = place_of(raster, "Y"), opacity = place_of(raster, "A");
  if (red == n || green == n || blue == n) red = green = blue = grey;
  if (red == n) throw InputError("has no channels R, G and B, and no Y");
  Image image(raster.width, raster.height);
  for (int y = 0; y < raster.height; ++y) {
    for (int x = 0; x < raster.width; ++x) {
      Rgb& pixel = image.at(x, y);
      pixel = Rgb(raster.at(x, y, red), raster.at(x, y, green), raster.at(x, y, blue));
      if (opacity != n) pixel.array() += 1 - raster.at(x, y, opacity);
      if (!pixel.allFinite())
        throw InputError(fmt::format("the pixel in column {}, row {} isn't finite", x, y));
    }
  }
  return image;
}

Image read_image(const std::filesystem::path& path) {
  return decode_image(read_whole_file(path), path.string());
}

void check_image_path(const std::filesystem::path& path) {
  is_exr(path);
  detail::check_place(path);
}

bool is_exr(const std::filesystem::path& path) {
  const std::string extension = detail::lower_case_extension(path);
  if (extension != ".png" && extension != ".exr")
    throw InputError::in_file(path.string(), "unknown kind of picture file; known are .png .exr");
  return extension == ".exr";
}

void write_image(const std::filesystem::path& path, const Image& image) {
  if (!is_exr(path)) return write_png(path, image);
  FloatRaster raster{image.width, image.height, {"R", "G", "B"}, {}};
  raster.samples.reserve(3 * image.pixels.size());
  for (const Rgb& pixel : image.pixels)
    raster.samples.insert(raster.samples.end(), pixel.begin(), pixel.end());
  write_file_atomically(path, encode_exr(raster));
}

}  // namespace recede
