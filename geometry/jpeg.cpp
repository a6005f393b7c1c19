#include <recede/geometry/error.h>
#include <recede/geometry/raster.h>

#include <array>
#include <cstdio>
#include <limits>

// Needs what <cstdio> has.
#include <jpeglib.h>

namespace recede {
namespace {

/// libjpeg's C code holds nothing that needs unwinding beyond the struct that JpegReader frees.
[[noreturn]] void throw_jpeg_error(j_common_ptr reader) {
  std::array<char, JMSG_LENGTH_MAX> reason{};
  reader->err->format_message(reader, reason.data());
  throw Error(std::string("JPEG: ") + reason.data());
}

// Warnings are of files that are damaged, which it would fill in with grey.
void throw_jpeg_warning(j_common_ptr reader, int level) {
  if (level < 0) throw_jpeg_error(reader);
}

struct JpegReader {
  jpeg_error_mgr errors{};
  jpeg_decompress_struct reader{};

  JpegReader() {
    reader.err = jpeg_std_error(&errors);
    errors.error_exit = throw_jpeg_error;
    errors.emit_message = throw_jpeg_warning;
    jpeg_create_decompress(&reader);
  }
  ~JpegReader() { jpeg_destroy_decompress(&reader); }
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;
};

Raster decode(std::string_view bytes) {
  if (bytes.size() > std::numeric_limits<unsigned long>::max()) throw Error("JPEG: the file is too large");
  JpegReader file;
  jpeg_decompress_struct& reader = file.reader;
  jpeg_mem_src(&reader, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&reader, TRUE);
  // A block of 64 texels takes a bit at least in Huffman's code, which all cameras and browsers use, so a
  // small file can't ask for all memory.
  constexpr std::size_t k_most_texels_per_byte = 8 * 64;
  const std::size_t texels = std::size_t{reader.image_width} * reader.image_height;
  if (texels / k_most_texels_per_byte > bytes.size()) throw Error("JPEG: the file ends too early");
  reader.out_color_space = reader.num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_start_decompress(&reader);
  Raster raster{.width = static_cast<int>(reader.output_width),
                .height = static_cast<int>(reader.output_height),
                .channels = reader.output_components,
                .bits = 8,
                .srgb = true,
                .samples = {}};
  raster.samples.reserve(texels * static_cast<std::size_t>(raster.channels));
  std::vector<unsigned char> row(static_cast<std::size_t>(raster.width) *
                                 static_cast<std::size_t>(raster.channels));
  while (reader.output_scanline < reader.output_height) {
    unsigned char* to = row.data();
    jpeg_read_scanlines(&reader, &to, 1);
    raster.samples.insert(raster.samples.end(), row.begin(), row.end());
  }
  jpeg_finish_decompress(&reader);
  return raster;
}

}  // namespace

Raster decode_jpeg(std::string_view bytes, const std::string& name) {
  try {
    return decode(bytes);
  } catch (const Error& error) {
    throw InputError::in_file(name, error.what());
  }
}

PictureFormat picture_format(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return PictureFormat::png;
  return bytes.starts_with("\xff\xd8\xff") ? PictureFormat::jpeg : PictureFormat::unknown;
}

Raster decode_picture(std::string_view bytes, const std::string& name) {
  switch (picture_format(bytes)) {
    case PictureFormat::png:
      return decode_png(bytes, name);
    case PictureFormat::jpeg:
      return decode_jpeg(bytes, name);
    case PictureFormat::unknown:
      break;
  }
  throw InputError::in_file(name, "is neither a PNG nor a JPEG picture");
}

}  // namespace recede
