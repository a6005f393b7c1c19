#include "input_errors.h"
#include <recede/geometry/displacement_map.h>
#include <recede/geometry/exr.h>

#include <gmock/gmock.h>

#include <limits>

namespace recede::test {
namespace {

using testing::HasSubstr;

TEST(DisplacementMapFiles, HoldWholeNumbersThatKeepTheirBits) {
  const TempFolder folder;
  for (const int bits : {8, 16}) {
    const int most = (1 << bits) - 1;
    const Raster raster{2, 1, 1, bits, false, {0, static_cast<std::uint16_t>(most)}};
    const DisplacementMap map = read_displacement_map(
        folder.write("a.PNG", encode_png(raster)), {.scale = 3, .offset = -1, .border = MapBorder::periodic});
    EXPECT_EQ(map.bits(), bits);
    EXPECT_EQ(map.texel(0, 0), -1);
    EXPECT_EQ(map.texel(1, 0), 2);
    EXPECT_EQ(map.border(), MapBorder::periodic);
  }
}

TEST(DisplacementMapFiles, HoldFloatsInTheChannelYOrInTheOnlyOne) {
  const TempFolder folder;
  const auto texel = [&](const FloatRaster& raster) {
    const DisplacementMap map =
        read_displacement_map(folder.write("a.exr", encode_exr(raster)), {.scale = 2});
    EXPECT_EQ(map.bits(), 0);
    return map.texel(1, 0);
  };
  EXPECT_EQ(texel({2, 1, {"Y"}, {1, 5}}), 10);
  EXPECT_EQ(texel({2, 1, {"height"}, {1, 5}}), 10);
  EXPECT_EQ(texel({2, 1, {"A", "Y"}, {1, 2, 3, 4}}), 8);
}

TEST(DisplacementMapFiles, AreRefusedWithTheReason) {
  const TempFolder folder;
  const auto refusal = [&](const std::string& name, const std::string& bytes,
                           const DisplacementMapOptions& options = {}) {
    return error_text([&] { read_displacement_map(folder.write(name, bytes), options); });
  };
  EXPECT_THAT(refusal("a.png", encode_png({1, 1, 3, 8, false, {0, 0, 0}})),
              HasSubstr("a.png: has 3 channels"));
  EXPECT_THAT(refusal("a.exr", encode_exr({1, 1, {"R", "G"}, {0, 0}})), HasSubstr("neither a channel Y"));
  constexpr float k_nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(refusal("a.exr", encode_exr({2, 1, {"Y"}, {0, k_nan}})),
              HasSubstr("a.exr: the height of texel (1, 0)"));
  EXPECT_THAT(refusal("a.exr", encode_exr({1, 1, {"Y"}, {1e30F}}), {.scale = 1e30}),
              HasSubstr("texel (0, 0)"));
  EXPECT_THAT(refusal("a.exr", "no picture"), HasSubstr("a.exr"));
  EXPECT_THAT(refusal("a.tiff", ""), HasSubstr("neither a .png nor an .exr"));
  EXPECT_THAT(refusal("a.png", "", {.offset = k_nan}), HasSubstr("finite"));
  EXPECT_THAT(error_text([&] { read_displacement_map(folder / "none.png"); }), HasSubstr("none.png"));
}

}  // namespace
}  // namespace recede::test
