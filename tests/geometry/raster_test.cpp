#include "input_errors.h"
#include "temp_folder.h"
#include <recede/geometry/error.h>
#include <recede/geometry/raster.h>

#include <gtest/gtest.h>

#include <random>

namespace recede {
namespace {

TEST(Raster, PngSaysBitsAndChannelsInItsHeader) {
  const auto header = [](int channels, int bits) {
    Raster raster{.width = 3, .height = 2, .channels = channels, .bits = bits, .samples = {}};
    raster.samples.assign(static_cast<std::size_t>(6 * channels), 200);
    const std::string file = encode_png(raster);
    return std::pair(int(file[24]), int(file[25]));  // behind signature, length, name, width and height
  };
  EXPECT_EQ(header(1, 16), std::pair(16, 0));
  EXPECT_EQ(header(1, 8), std::pair(8, 0));
  EXPECT_EQ(header(3, 8), std::pair(8, 2));
  EXPECT_EQ(header(3, 16), std::pair(16, 2));
}

TEST(Raster, PngComesBackWithItsSamplesAndWhatItSaysOfThem) {
  std::mt19937 random(2);
  for (const int channels : {1, 3, 4}) {
    for (const int bits : {8, 16}) {
      Raster raster{
          .width = 7, .height = 5, .channels = channels, .bits = bits, .srgb = bits == 8, .samples = {}};
      for (int i = 0; i < 35 * channels; ++i)
        raster.samples.push_back(static_cast<std::uint16_t>(random() % (1u << bits)));
      EXPECT_EQ(decode_png(encode_png(raster), "test.png"), raster) << channels << ' ' << bits;
    }
  }
}

TEST(Raster, BadPngFilesAreRefusedWithTheirName) {
  const test::TempFolder folder;
  for (const char* bytes : {"", "P6 1 1 255 abc", "\x89PNG\r\n\x1a\n"}) {
    const std::string path = folder.write("bad.png", bytes);
    EXPECT_EQ(test::error_text([&] { read_png(path); }).find(path + ": "), 0u);
    EXPECT_THROW(read_png(path), InputError);
  }
}

TEST(Raster, PngOfImpossibleRastersIsRefused) {
  EXPECT_THROW(encode_png(Raster{}), OptionError);
  EXPECT_THROW(encode_png({.width = 1, .height = 1, .channels = 2, .samples = {0, 0}}), OptionError);
  EXPECT_THROW(encode_png({.width = 1, .height = 1, .bits = 12, .samples = {0}}), OptionError);
  EXPECT_THROW(encode_png({.width = 2, .height = 1, .samples = {0}}), OptionError);
}

}  // namespace
}  // namespace recede
