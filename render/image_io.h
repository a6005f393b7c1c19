// Files of pictures: PNG and OpenEXR in, linear light out, and back.
#pragma once

#include <recede/geometry/exr.h>
#include <recede/geometry/raster.h>
#include <recede/render/image.h>

#include <filesystem>

namespace recede {

/// Samples as linear light: decoded by the sRGB transfer function, whatever the raster says of its own. Grey
/// has three equal channels. What isn't opaque is laid over white, in linear light.
Image to_image(const Raster& raster);

/// The channels R, G and B, or else Y as grey, which are linear already; others are left aside. With a
/// channel A the colours count as multiplied by it, as OpenEXR has it, and are laid over white. Throws
/// `InputError` when there are no such channels, or a number isn't finite.
Image to_image(const FloatRaster& raster);

/// A PNG file (8 or 16 bits and fewer; grey, colours or palette; with or without opacity; chunks that say
/// anything else than sRGB are left aside) or an OpenEXR file, told apart by what they hold. Throws
/// `InputError` with the path and the reason.
Image read_image(const std::filesystem::path& path);

/// Writes `.png` (8 bits a channel, sRGB, clamped to 0..1) or `.exr` (R, G and B, linear 32-bit floats), by
/// the extension in any case. No half-written file is ever seen. Throws `InputError` for other extensions and
/// when the file can't be written.
void write_image(const std::filesystem::path& path, const Image& image);

/// Throws `InputError` when `path` can't become a picture: unknown extension, a folder of that name, or no
/// folder to be in. For programs that work long before they write.
void check_image_path(const std::filesystem::path& path);

/// Whether `write_image` makes an OpenEXR file of that name. Throws `InputError` for extensions that it
/// doesn't know.
bool is_exr(const std::filesystem::path& path);

}  // namespace recede
