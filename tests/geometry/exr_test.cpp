#include "input_errors.h"
#include "temp_folder.h"
#include <recede/geometry/error.h>
#include <recede/geometry/exr.h>

#include <gmock/gmock.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

namespace recede {
namespace {

void put_u32(std::string& bytes, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> (8 * i));
}

/// An attribute of a header.
void put(std::string& bytes, std::string_view name, std::string_view type, std::string_view value) {
  bytes.append(name).append(1, '\0').append(type).append(1, '\0');
  put_u32(bytes, static_cast<std::uint32_t>(value.size()));
  bytes.append(value);
}

std::string numbers(const std::vector<std::uint32_t>& values) {
  std::string bytes;
  for (const std::uint32_t value : values) put_u32(bytes, value);
  return bytes;
}

/// A file without compression by the format's description: channels G and Z of floats in the window from
/// (5, 7) to (6, 7).
std::string file_by_hand(std::uint32_t sampling = 1) {
  std::string file("\x76\x2f\x31\x01\x02\0\0\0", 8);
  std::string channels;
  for (const char* name : {"G", "Z"}) {
    channels.append(name).append(1, '\0');
    channels += numbers({2, 0, sampling, sampling});
  }
  channels.append(1, '\0');
  put(file, "channels", "chlist", channels);
  put(file, "compression", "compression", std::string(1, '\0'));
  put(file, "dataWindow", "box2i", numbers({5, 7, 6, 7}));
  put(file, "displayWindow", "box2i", numbers({0, 0, 9, 9}));
  put(file, "lineOrder", "lineOrder", std::string(1, '\0'));
  put(file, "pixelAspectRatio", "float", numbers({std::bit_cast<std::uint32_t>(1.0f)}));
  put(file, "screenWindowCenter", "v2f", numbers({0, 0}));
  put(file, "screenWindowWidth", "float", numbers({std::bit_cast<std::uint32_t>(1.0f)}));
  file.append(1, '\0');
  put_u32(file, static_cast<std::uint32_t>(file.size() + 8));  // where the only line begins
  put_u32(file, 0);
  file += numbers({7, 16});
  for (const float value : {1.5f, -2.0f, 1e30f, 0.25f}) put_u32(file, std::bit_cast<std::uint32_t>(value));
  return file;
}

FloatRaster noise(int width, int height, std::vector<std::string> channels) {
  FloatRaster raster{width, height, std::move(channels), {}};
  std::mt19937 random(7);
  std::normal_distribution<float> value(0, 3);
  raster.samples.resize(static_cast<std::size_t>(width * height) * raster.channels.size());
  for (float& sample : raster.samples) sample = value(random);
  return raster;
}

TEST(Exr, FloatsComeBackBitForBit) {
  FloatRaster raster = noise(13, 37, {"Y"});  // more lines than a block of ZIP has
  raster.samples[0] = -0.0f;
  raster.samples[1] = std::numeric_limits<float>::denorm_min();
  raster.samples[2] = std::numeric_limits<float>::max();
  raster.samples[3] = -std::numeric_limits<float>::infinity();
  const FloatRaster back = decode_exr(encode_exr(raster), "test.exr");
  EXPECT_EQ(back, raster);
  EXPECT_TRUE(std::signbit(back.samples[0]));
}

TEST(Exr, ColoursComeBackInTheirOrderAndOtherChannelsByName) {
  const FloatRaster raster = noise(4, 3, {"R", "G", "B", "A", "Ns.x", "Z"});
  EXPECT_EQ(decode_exr(encode_exr(raster), "test.exr"), raster);
  const FloatRaster mixed = noise(4, 3, {"Z", "B", "R"});
  const FloatRaster back = decode_exr(encode_exr(mixed), "test.exr");
  EXPECT_THAT(back.channels, testing::ElementsAre("R", "B", "Z"));
  EXPECT_EQ(back.at(3, 1, 0), mixed.at(3, 1, 2));
  EXPECT_EQ(back.at(3, 1, 1), mixed.at(3, 1, 1));
  EXPECT_EQ(back.at(3, 1, 2), mixed.at(3, 1, 0));
}

TEST(Exr, HalvesKeepElevenBits) {
  const FloatRaster raster = noise(16, 16, {"R", "G", "B"});
  const std::string halves = encode_exr(raster, {.half = true, .comments = {}});
  EXPECT_LT(halves.size(), encode_exr(raster).size());
  const FloatRaster back = decode_exr(halves, "test.exr");
  ASSERT_EQ(back.samples.size(), raster.samples.size());
  for (std::size_t i = 0; i < back.samples.size(); ++i) {
    // Half a step of 10 stored bits.
    EXPECT_NEAR(back.samples[i], raster.samples[i], std::abs(raster.samples[i]) / 2048 + 3e-8);
  }
}

TEST(Exr, FilesSayWhatTheyHold) {
  const FloatRaster raster = noise(3, 2, {"Y"});
  const std::string file = encode_exr(raster, {.half = false, .comments = "object units"});
  EXPECT_EQ(file.substr(0, 8), std::string("\x76\x2f\x31\x01\x02\0\0\0", 8));
  EXPECT_NE(file.find(std::string("Y\0\2\0\0\0", 6)), file.npos) << "32-bit floats";
  EXPECT_NE(file.find("object units"), file.npos);
  EXPECT_NE(encode_exr(raster, {.half = true, .comments = {}}).find(std::string("Y\0\1\0\0\0", 6)),
            file.npos);
  EXPECT_EQ(file, encode_exr(raster, {.half = false, .comments = "object units"})) << "no times, no names";
}

TEST(Exr, AFileWrittenByHandIsRead) {
  const FloatRaster raster = decode_exr(file_by_hand(), "hand.exr");
  EXPECT_EQ(raster, (FloatRaster{2, 1, {"G", "Z"}, {1.5f, 1e30f, -2.0f, 0.25f}}));
}

TEST(Exr, ImpossibleRastersAreRefused) {
  EXPECT_THROW(encode_exr({}), OptionError);
  EXPECT_THROW(encode_exr({1, 1, {}, {}}), OptionError);
  EXPECT_THROW(encode_exr({1, 1, {"Y", "Y"}, {0, 0}}), OptionError);
  EXPECT_THROW(encode_exr({1, 1, {""}, {0}}), OptionError);
  EXPECT_THROW(encode_exr({2, 1, {"Y"}, {0}}), OptionError);
}

TEST(Exr, BadFilesGiveOneLineWithTheirName) {
  const test::TempFolder folder;
  const auto complaint = [&](std::string_view bytes) {
    const std::string text = test::error_text([&] { read_exr(folder.write("bad.exr", bytes)); });
    EXPECT_EQ(text.find('\n'), text.npos) << text;
    EXPECT_EQ(text.find("bad.exr: "), text.find("bad.exr")) << text;
    EXPECT_EQ(text.find("bad.exr"), text.rfind("bad.exr")) << text;
    return text;
  };
  EXPECT_NE(complaint("").find("bad.exr: "), std::string::npos);
  EXPECT_NE(complaint("P6 1 1 255 abc").find("bad.exr: "), std::string::npos);
  EXPECT_NE(complaint(file_by_hand(2)).find("bad.exr: "), std::string::npos);
  EXPECT_THROW(read_exr(folder / "missing.exr"), InputError);

  std::string huge = file_by_hand();  // two billion texels in both directions
  const std::string window = numbers({5, 7, 6, 7});
  huge.replace(huge.find(window), window.size(), numbers({0, 0, 0x7ffffff0, 0x7ffffff0}));
  EXPECT_NE(complaint(huge).find("bad.exr: "), std::string::npos);
}

TEST(Exr, CutAndDamagedFilesNeverCrash) {
  const std::string file = encode_exr(noise(9, 20, {"R", "G", "B"}));
  for (std::size_t size = 0; size < file.size(); size += size < 600 ? 1 : 17)
    EXPECT_THROW(decode_exr(file.substr(0, size), "cut.exr"), InputError) << size;
  std::mt19937 random(3);
  std::size_t refused = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string damaged = file;
    for (int k = 0; k < 3; ++k) damaged[random() % damaged.size()] = static_cast<char>(random());
    try {
      const FloatRaster back = decode_exr(damaged, "damaged.exr");
      EXPECT_EQ(back.samples.size(),
                static_cast<std::size_t>(back.width * back.height) * back.channels.size());
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 200u);
}

}  // namespace
}  // namespace recede
