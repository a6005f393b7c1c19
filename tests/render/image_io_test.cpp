#include "input_errors.h"
#include "temp_folder.h"
#include <recede/render/image_io.h>

#include <gmock/gmock.h>
#include <png.h>

#include <limits>
#include <random>

namespace recede {
namespace {

using testing::HasSubstr;

/// A PNG file written by libpng alone. Rows of samples as the file has them.
std::string png_file(int width, int height, int color_type, int bits,
                     const std::vector<std::vector<int>>& rows, int interlace = PNG_INTERLACE_NONE) {
  std::string file;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &file,
      [](png_structp writer, png_bytep bytes, std::size_t count) {
        static_cast<std::string*>(png_get_io_ptr(writer))
            ->append(reinterpret_cast<const char*>(bytes), count);
      },
      nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), bits, color_type,
               interlace, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (color_type == PNG_COLOR_TYPE_PALETTE) {
    const png_color colors[] = {{255, 0, 0}, {0, 51, 0}, {0, 0, 102}};
    const png_byte opacities[] = {255, 255, 0};
    png_set_PLTE(png, info, colors, 3);
    png_set_tRNS(png, info, opacities, 3, nullptr);
  }
  png_write_info(png, info);
  if (bits < 8) png_set_packing(png);
  std::vector<std::vector<png_byte>> content;
  for (const std::vector<int>& row : rows) {
    content.emplace_back();
    for (const int sample : row) {
      if (bits == 16) content.back().push_back(static_cast<png_byte>(sample >> 8));
      content.back().push_back(static_cast<png_byte>(sample & 0xff));
    }
  }
  std::vector<png_bytep> pointers;
  for (std::vector<png_byte>& row : content) pointers.push_back(row.data());
  png_write_image(png, pointers.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return file;
}

Image read_bytes(std::string_view bytes) {
  const test::TempFolder folder;
  return read_image(folder.write("picture", bytes));
}

Rgb encoded(double red, double green, double blue) {
  return {decode_srgb(static_cast<float>(red)), decode_srgb(static_cast<float>(green)),
          decode_srgb(static_cast<float>(blue))};
}

// Same formulas on both sides, up to the rounding of floats.
constexpr float k_rounding = 1e-6f;

TEST(ImageIo, PngOfEightBitsIsDecodedToLinearLight) {
  const Image grey = read_bytes(png_file(2, 1, PNG_COLOR_TYPE_GRAY, 8, {{0, 128}}));
  ASSERT_EQ(grey.width, 2);
  ASSERT_EQ(grey.height, 1);
  EXPECT_EQ(grey.at(0, 0), Rgb::Zero());
  EXPECT_NEAR(grey.at(1, 0).x(), 0.2158605f, 1e-6f) << "of IEC 61966-2-1";
  EXPECT_EQ(grey.at(1, 0).x(), grey.at(1, 0).z());
  const Image colors = read_bytes(png_file(1, 2, PNG_COLOR_TYPE_RGB, 8, {{255, 51, 0}, {0, 0, 102}}));
  ASSERT_EQ(colors.height, 2);
  EXPECT_TRUE(colors.at(0, 0).isApprox(encoded(1, 0.2, 0), k_rounding));
  EXPECT_TRUE(colors.at(0, 1).isApprox(encoded(0, 0, 0.4), k_rounding));
}

TEST(ImageIo, PngOfSixteenBitsKeepsThem) {
  const Image image = read_bytes(png_file(2, 1, PNG_COLOR_TYPE_RGB, 16, {{32768, 32769, 1, 65535, 0, 257}}));
  EXPECT_TRUE(image.at(0, 0).isApprox(encoded(32768 / 65535.0, 32769 / 65535.0, 1 / 65535.0), k_rounding));
  EXPECT_LT(image.at(0, 0).x(), image.at(0, 0).y());
  EXPECT_TRUE(image.at(1, 0).isApprox(encoded(1, 0, 1 / 255.0), k_rounding));
}

TEST(ImageIo, FewerBitsArePlacedOnTheWholeScale) {
  const Image four = read_bytes(png_file(3, 1, PNG_COLOR_TYPE_GRAY, 2, {{0, 1, 3}}));
  EXPECT_TRUE(four.at(1, 0).isApprox(encoded(1 / 3.0, 1 / 3.0, 1 / 3.0), k_rounding));
  EXPECT_EQ(four.at(2, 0), Rgb::Ones());
}

TEST(ImageIo, WhatIsNotOpaqueLiesOverWhite) {
  const Image colors =
      read_bytes(png_file(3, 1, PNG_COLOR_TYPE_RGB_ALPHA, 8, {{255, 0, 0, 255, 255, 0, 0, 51, 7, 8, 9, 0}}));
  EXPECT_EQ(colors.at(0, 0), Rgb(1, 0, 0));
  EXPECT_TRUE(colors.at(1, 0).isApprox(Rgb(1, 0.8f, 0.8f), k_rounding)) << "a fifth of red, in linear light";
  EXPECT_EQ(colors.at(2, 0), Rgb::Ones());
  const Image grey = read_bytes(png_file(2, 1, PNG_COLOR_TYPE_GRAY_ALPHA, 16, {{0, 13107, 65535, 65535}}));
  EXPECT_TRUE(grey.at(0, 0).isApprox(Rgb::Constant(0.8f), k_rounding));
  EXPECT_EQ(grey.at(1, 0), Rgb::Ones());
  const Image palette = read_bytes(png_file(3, 1, PNG_COLOR_TYPE_PALETTE, 4, {{0, 1, 2}}));
  EXPECT_EQ(palette.at(0, 0), Rgb(1, 0, 0));
  EXPECT_TRUE(palette.at(1, 0).isApprox(encoded(0, 0.2, 0), k_rounding));
  EXPECT_EQ(palette.at(2, 0), Rgb::Ones()) << "transparent";
}

TEST(ImageIo, InterlacedPngHasItsPixelsInPlace) {
  std::vector<std::vector<int>> rows(9, std::vector<int>(11));
  std::mt19937 random(5);
  for (std::vector<int>& row : rows) {
    for (int& sample : row) sample = static_cast<int>(random() % 256);
  }
  const Image straight = read_bytes(png_file(11, 9, PNG_COLOR_TYPE_GRAY, 8, rows));
  const Image interlaced = read_bytes(png_file(11, 9, PNG_COLOR_TYPE_GRAY, 8, rows, PNG_INTERLACE_ADAM7));
  EXPECT_EQ(straight.pixels, interlaced.pixels);
}

TEST(ImageIo, WrittenPicturesComeBack) {
  std::mt19937 random(9);
  std::uniform_real_distribution<float> light(0, 1);
  Image image(7, 5);
  for (Rgb& pixel : image.pixels) pixel = Rgb(light(random), light(random), light(random));
  const test::TempFolder folder;
  write_image(folder / "a.exr", image);
  EXPECT_EQ(read_image(folder / "a.exr").pixels, image.pixels) << "bit for bit";
  image.at(3, 2) = Rgb(-1, 4, 1e6f);
  write_image(folder / "b.EXR", image);
  EXPECT_EQ(read_image(folder / "b.EXR").pixels, image.pixels);
  write_image(folder / "c.PNG", image);
  const Image back = read_image(folder / "c.PNG");
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    for (int channel = 0; channel < 3; ++channel) {
      // Half a step of 8 bits, and the rounding of floats.
      EXPECT_NEAR(encode_srgb(back.pixels[i][channel]), encode_srgb(image.pixels[i][channel]),
                  0.5f / 255 + k_rounding);
    }
  }
}

TEST(ImageIo, ExrMayBeGreyOrHaveOpacity) {
  const Image grey = to_image(FloatRaster{2, 1, {"Y", "Z"}, {0.25f, 7, 3, 7}});
  EXPECT_EQ(grey.at(0, 0), Rgb::Constant(0.25f));
  EXPECT_EQ(grey.at(1, 0), Rgb::Constant(3));
  const Image colors = to_image(FloatRaster{1, 1, {"R", "G", "B", "A"}, {0.25f, 0, 0, 0.25f}});
  EXPECT_EQ(colors.at(0, 0), Rgb(1, 0.75f, 0.75f)) << "colours are multiplied by their opacity already";
  const test::TempFolder folder;
  const FloatRaster halves{1, 1, {"R", "G", "B"}, {0.5f, 2, -0.125f}};
  const std::string path = folder.write("half.exr", encode_exr(halves, {.half = true, .comments = {}}));
  EXPECT_EQ(read_image(path).at(0, 0), Rgb(0.5f, 2, -0.125f));
}

/// The complaint about a file of these bytes, behind its name.
std::string complaint(std::string_view bytes) {
  const test::TempFolder folder;
  const std::string path = folder.write("bad.picture", bytes);
  const std::string text = test::error_text([&] { read_image(path); });
  EXPECT_TRUE(text.starts_with(path + ": ")) << text;
  EXPECT_EQ(text.find('\n'), text.npos) << text;
  EXPECT_THROW(read_image(path), InputError);
  return text.substr(std::min(text.size(), path.size() + 2));
}

TEST(ImageIo, BadFilesGiveOneLineWithTheirNameAndTheReason) {
  const std::string neither = "is neither a PNG nor an OpenEXR picture";
  EXPECT_EQ(complaint(""), neither);
  EXPECT_EQ(complaint("GIF89a"), neither);
  EXPECT_EQ(complaint("\x89PNG"), neither);
  EXPECT_EQ(complaint("\x89PNG\r\n\x1a\n"), "the file ends too early");
  EXPECT_EQ(test::error_text([] { read_image("missing.png"); }), "missing.png: No such file or directory");

  const std::string png = png_file(3, 2, PNG_COLOR_TYPE_GRAY, 8, {{1, 2, 3}, {4, 5, 6}});
  EXPECT_EQ(complaint(png.substr(0, png.size() / 2)), "the file ends too early");
  std::string damaged = png;
  damaged[16] = 1;  // the width, behind signature, length and name
  EXPECT_THAT(complaint(damaged), HasSubstr("CRC"));

  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinite = std::numeric_limits<float>::infinity();
  EXPECT_EQ(complaint(encode_exr({2, 1, {"Y"}, {0, nan}})), "the pixel in column 1, row 0 isn't finite");
  EXPECT_EQ(complaint(encode_exr({1, 1, {"R", "G", "B"}, {0, infinite, 0}})),
            "the pixel in column 0, row 0 isn't finite");
  EXPECT_EQ(complaint(encode_exr({1, 1, {"R", "B", "Z"}, {0, 0, 0}})),
            "has no channels R, G and B, and no Y");
}

/// A PNG file that says it has these sides and holds next to nothing, with a right checksum.
std::string empty_png(std::uint32_t width, std::uint32_t height) {
  std::string file = png_file(1, 1, PNG_COLOR_TYPE_GRAY, 8, {{0}});
  for (int i = 0; i < 4; ++i) {
    file[static_cast<std::size_t>(16 + i)] = static_cast<char>(width >> (24 - 8 * i));
    file[static_cast<std::size_t>(20 + i)] = static_cast<char>(height >> (24 - 8 * i));
  }
  std::uint32_t crc = 0xffffffffu;  // of PNG's specification, annex D
  for (std::size_t i = 12; i < 29; ++i) {
    crc ^= static_cast<std::uint8_t>(file[i]);
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? 0xedb88320u ^ (crc >> 1) : crc >> 1;
  }
  for (int i = 0; i < 4; ++i)
    file[static_cast<std::size_t>(29 + i)] = static_cast<char>(~crc >> (24 - 8 * i));
  return file;
}

TEST(ImageIo, SizesThatCantBeAreRefused) {
  EXPECT_EQ(read_bytes(empty_png(1, 1)).width, 1);
  EXPECT_EQ(complaint(empty_png(0, 1)), "there are no pixels");
  EXPECT_EQ(complaint(empty_png(1, 0)), "there are no pixels");
  EXPECT_THAT(complaint(empty_png(900'000, 900'000)), HasSubstr("too early"));
  EXPECT_NE(complaint(empty_png(0x7fffffff, 0x7fffffff)), "");
}

TEST(ImageIo, CutAndDamagedPngFilesNeverCrash) {
  std::vector<std::vector<int>> rows(20, std::vector<int>(4 * 9));
  std::mt19937 random(3);
  for (std::vector<int>& row : rows) {
    for (int& sample : row) sample = static_cast<int>(random() % 256);
  }
  const std::string file = png_file(9, 20, PNG_COLOR_TYPE_RGB_ALPHA, 8, rows);
  for (std::size_t size = 0; size < file.size(); size += 7)
    EXPECT_THROW(decode_png(file.substr(0, size), "cut.png"), InputError) << size;
  std::size_t refused = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string damaged = file;
    damaged[random() % damaged.size()] = static_cast<char>(random());
    try {
      const Raster back = decode_png(damaged, "damaged.png");
      EXPECT_EQ(back.samples.size(), static_cast<std::size_t>(back.width * back.height * back.channels));
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000u) << "checksums find nearly all";
}

TEST(ImageIo, OtherExtensionsAreRefusedAndLeaveNothing) {
  const test::TempFolder folder;
  EXPECT_THAT(test::error_text([&] { write_image(folder / "a.jpg", Image(1, 1)); }),
              HasSubstr("a.jpg: unknown kind of picture file; known are .png .exr"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace recede
