// JPEG files, which Recede only reads.
#pragma once

#include <recede/geometry/raster.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

// Needs what <cstdio> has.
#include <jpeglib.h>

namespace recede::test {

/// A JPEG file written by libjpeg alone.
inline std::string jpeg_of(const Raster& raster, int quality) {
  jpeg_compress_struct writer;
  jpeg_error_mgr errors;
  writer.err = jpeg_std_error(&errors);
  jpeg_create_compress(&writer);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&writer, &bytes, &size);
  writer.image_width = static_cast<unsigned>(raster.width);
  writer.image_height = static_cast<unsigned>(raster.height);
  writer.input_components = raster.channels;
  writer.in_color_space = raster.channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_set_defaults(&writer);
  jpeg_set_quality(&writer, quality, TRUE);
  jpeg_start_compress(&writer, TRUE);
  std::vector<unsigned char> samples(raster.samples.begin(), raster.samples.end());
  const std::size_t row = static_cast<std::size_t>(raster.width) * static_cast<std::size_t>(raster.channels);
  for (std::size_t y = 0; y < static_cast<std::size_t>(raster.height); ++y) {
    unsigned char* line = samples.data() + y * row;
    jpeg_write_scanlines(&writer, &line, 1);
  }
  jpeg_finish_compress(&writer);
  std::string file(reinterpret_cast<const char*>(bytes), size);
  jpeg_destroy_compress(&writer);
  std::free(bytes);
  return file;
}

}  // namespace recede::test
