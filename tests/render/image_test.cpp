#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/render/image.h>

#include <gmock/gmock.h>
#include <png.h>

#include <limits>
#include <random>

namespace recede {
namespace {

// Rows of 8-bit RGB, read by libpng's simplified interface, which shares no code of ours.
std::vector<png_byte> decode(const std::string& file, int& width, int& height) {
  png_image reader{};
  reader.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&reader, file.data(), file.size()), 0) << reader.message;
  reader.format = PNG_FORMAT_RGB;
  std::vector<png_byte> bytes(PNG_IMAGE_SIZE(reader));
  EXPECT_NE(png_image_finish_read(&reader, nullptr, bytes.data(), 0, nullptr), 0) << reader.message;
  width = static_cast<int>(reader.width);
  height = static_cast<int>(reader.height);
  return bytes;
}

TEST(Image, PngDecodesToTheSamePixels) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> byte(0, 255);
  Image image(13, 5);
  std::vector<int> expected;
  for (Rgb& pixel : image.pixels) {
    for (int channel = 0; channel < 3; ++channel) {
      expected.push_back(byte(random));
      pixel[channel] = decode_srgb(static_cast<float>(expected.back()) / 255.0f);
    }
  }
  const std::string file = encode_png(image);
  EXPECT_EQ(file.substr(0, 8), "\x89PNG\r\n\x1a\n");
  int width = 0, height = 0;
  const std::vector<png_byte> decoded = decode(file, width, height);
  EXPECT_EQ(width, 13);
  EXPECT_EQ(height, 5);
  EXPECT_THAT(decoded, testing::ElementsAreArray(expected));
}

TEST(Image, PngClampsLightBeyondWhite) {
  Image image(1, 1, Rgb(4.0f, -1.0f, 1.0f));
  int width = 0, height = 0;
  EXPECT_THAT(decode(encode_png(image), width, height), testing::ElementsAre(255, 0, 255));
}

TEST(Image, AWrittenPngHoldsTheEncodedBytes) {
  const auto path =
      std::filesystem::temp_directory_path() / ("recede_image_test_" + std::to_string(getpid()) + ".png");
  const Image image(3, 2, Rgb(0.5f, 0.25f, 0.125f));
  write_png(path, image);
  EXPECT_EQ(read_whole_file(path), encode_png(image));
  std::filesystem::remove(path);
}

TEST(Image, SrgbHasTheStandardsValues) {
  EXPECT_FLOAT_EQ(encode_srgb(0), 0);
  EXPECT_FLOAT_EQ(encode_srgb(1), 1);
  EXPECT_NEAR(encode_srgb(0.5f), 0.735357f, 1e-5f);
  EXPECT_NEAR(encode_srgb(0.002f), 0.02584f, 1e-6f);
  for (const float value : {0.001f, 0.03f, 0.2f, 0.9f})
    EXPECT_NEAR(decode_srgb(encode_srgb(value)), value, 1e-6f);
  EXPECT_TRUE(rgb_from_hex(0xff0000).isApprox(Rgb(1, 0, 0)));
}

TEST(Image, ShrinkingTakesMeansOverBlocksAndOverWhatIsLeftAtTheBorder) {
  Image image(3, 2);
  for (int i = 0; i < 6; ++i)
    image.pixels[static_cast<std::size_t>(i)] = Rgb::Constant(static_cast<float>(i));
  const Image small = shrink(image, 2);
  EXPECT_EQ(small.width, 2);
  EXPECT_EQ(small.height, 1);
  EXPECT_FLOAT_EQ(small.at(0, 0).x(), (0 + 1 + 3 + 4) / 4.0f);
  EXPECT_FLOAT_EQ(small.at(1, 0).x(), (2 + 5) / 2.0f);
  for (const int factor : {3, 100, std::numeric_limits<int>::max()}) {
    const Image one = shrink(image, factor);
    ASSERT_EQ(one.pixels.size(), 1u) << factor;
    EXPECT_FLOAT_EQ(one.at(0, 0).x(), 2.5f);
  }
}

TEST(Image, ImagesSideBySideStandInTheMiddleOfTheHighest) {
  const Rgb red(1, 0, 0), green(0, 1, 0), white(1, 1, 1);
  const std::vector<Image> images{Image(2, 4, red), Image(1, 1, green), Image(1, 2, green)};
  const Image all = side_by_side(images);
  ASSERT_EQ(all.width, 4);
  ASSERT_EQ(all.height, 4);
  const std::vector<Rgb> rows[] = {
      {red, red, white, white}, {red, red, green, green}, {red, red, white, green}, {red, red, white, white}};
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 4; ++x) {
      EXPECT_EQ(all.at(x, y), rows[y][static_cast<std::size_t>(x)]) << x << ' ' << y;
    }
  }
}

TEST(Image, ImagesSideBySideKeepTheirPixels) {
  Image left(2, 2), right(3, 2);
  float value = 0;
  for (Image* image : {&left, &right}) {
    for (Rgb& pixel : image->pixels) pixel = Rgb::Constant(value += 0.0625f);
  }
  const Image both = side_by_side(std::vector<Image>{left, right});
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 2; ++x) EXPECT_EQ(both.at(x, y), left.at(x, y));
    for (int x = 0; x < 3; ++x) EXPECT_EQ(both.at(2 + x, y), right.at(x, y));
  }
  EXPECT_THROW(side_by_side({}), OptionError);
}

TEST(Image, ImagesWithoutPixelsAreRefused) { EXPECT_THROW(Image(0, 4), OptionError); }

}  // namespace
}  // namespace recede
