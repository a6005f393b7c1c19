#include <recede/geometry/error.h>
#include <recede/geometry/raster.h>

#include <gtest/gtest.h>

#include <cstring>

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

TEST(Raster, PngOfImpossibleRastersIsRefused) {
  EXPECT_THROW(encode_png(Raster{}), OptionError);
  EXPECT_THROW(encode_png({.width = 1, .height = 1, .channels = 2, .samples = {0, 0}}), OptionError);
  EXPECT_THROW(encode_png({.width = 1, .height = 1, .bits = 12, .samples = {0}}), OptionError);
  EXPECT_THROW(encode_png({.width = 2, .height = 1, .samples = {0}}), OptionError);
}

}  // namespace
}  // namespace recede
