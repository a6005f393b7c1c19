#include "error_text.h"
#include "jpegs.h"
#include "pictures.h"
#include "temp_folder.h"
#include <recede/geometry/error.h>
#include <recede/geometry/texture.h>

#include <gmock/gmock.h>

namespace recede::test {
namespace {

using testing::HasSubstr;

// Samples of 16 bits, which linear light is stored with, are half a step off at most.
constexpr double k_step = 1.0 / 65535;

MATCHER_P(IsColor, expected, "") { return (arg - Vec3(expected)).cwiseAbs().maxCoeff() <= k_step; }

Raster grey(int width, int height, std::vector<std::uint16_t> samples, int bits = 8) {
  return {.width = width,
          .height = height,
          .channels = 1,
          .bits = bits,
          .srgb = false,
          .samples = std::move(samples)};
}

TEST(Texture, IsThePictureInTheMiddlesOfTexelsAndLinearLightBetween) {
  const Texture texture(four_colors());
  EXPECT_THAT(texture.color_at({0.25, 0.75}), IsColor(Vec3(1, 0, 0))) << "upper left";
  EXPECT_THAT(texture.color_at({0.75, 0.75}), IsColor(Vec3(0, 1, 0)));
  EXPECT_THAT(texture.color_at({0.25, 0.25}), IsColor(Vec3(0, 0, 1)));
  EXPECT_THAT(texture.color_at({0.75, 0.25}), IsColor(Vec3(1, 1, 1)));
  EXPECT_THAT(texture.color_at({0.5, 0.75}), IsColor(Vec3(0.5, 0.5, 0)));
  EXPECT_THAT(texture.color_at({0.5, 0.5}), IsColor(Vec3(0.5, 0.5, 0.5)));
}

TEST(Texture, RepeatsBeyondTheUnitSquare) {
  const Texture texture(four_colors());
  for (const Vec2& uv : {Vec2(0.3, 0.6), Vec2(0, 0), Vec2(0.999, 0.001), Vec2(0.5, 0.5)}) {
    for (const Vec2& whole : {Vec2(1, 0), Vec2(-3, 2), Vec2(0, -1)})
      EXPECT_THAT(texture.color_at(uv + whole), IsColor(texture.color_at(uv)));
  }
  EXPECT_THAT(texture.color_at({0, 0.75}), IsColor(Vec3(0.5, 0.5, 0)))
      << "between its right and its left side";
}

TEST(Texture, TakesSamplesAsSrgbOfOneToFourChannels) {
  EXPECT_NEAR(Texture(grey(1, 1, {188})).color_at({0, 0}).x(), 0.5029, 1e-4) << "the formula of sRGB";
  EXPECT_THAT(Texture(grey(1, 1, {188 * 257}, 16)).color_at({0, 0}),
              IsColor(Texture(grey(1, 1, {188})).color_at({0, 0})));
  Raster with_opacity = grey(1, 1, {255, 0});
  with_opacity.channels = 2;
  EXPECT_THAT(Texture(with_opacity).color_at({0, 0}), IsColor(Vec3(1, 1, 1)));
  Raster colors = grey(1, 1, {255, 0, 0, 0});
  colors.channels = 4;
  EXPECT_THAT(Texture(colors).color_at({0, 0}), IsColor(Vec3(1, 0, 0)));
  EXPECT_THROW(Texture(grey(0, 0, {})), InputError);
  EXPECT_THROW(Texture(grey(2, 1, {1})), InputError);
}

TEST(Texture, WideLooksSeeTheMean) {
  // Columns of black and white: from two texels on nothing of them is left.
  std::vector<std::uint16_t> columns;
  for (int i = 0; i < 64 * 64; ++i) columns.push_back(i % 2 == 0 ? 0 : 255);
  const Texture texture(grey(64, 64, columns));
  EXPECT_NEAR(texture.color_at({0.5 / 64, 0.5}).x(), 0, k_step);
  for (const double texels : {2.0, 3.0, 64.0, 1e9}) {
    for (const double u : {0.5 / 64, 1.0 / 64, 0.77})
      EXPECT_NEAR(texture.color_at({u, 0.3}, texels / 64).x(), 0.5, k_step) << texels;
  }
  EXPECT_NEAR(texture.color_at({0.5 / 64, 0.5}, std::sqrt(2.0) / 64).x(), 0.25, 1e-4)
      << "half of the way to the next picture";
}

TEST(Jpeg, AFlatPictureComesBackAndSharpOnesNearly) {
  const Raster flat = raster_of(20, 10, std::vector<std::array<std::uint16_t, 3>>(200, {200, 100, 50}));
  const Raster back = decode_jpeg(jpeg_of(flat, 95), "flat.jpg");
  EXPECT_EQ(back.width, 20);
  EXPECT_EQ(back.height, 10);
  EXPECT_EQ(back.channels, 3);
  EXPECT_TRUE(back.srgb);
  // Colours are rounded on their way through brightness and two differences.
  for (std::size_t i = 0; i < back.samples.size(); ++i)
    ASSERT_NEAR(back.samples[i], flat.samples[i], 2) << "sample " << i;
  std::vector<std::uint16_t> ramp;
  for (int i = 0; i < 256; ++i) ramp.push_back(static_cast<std::uint16_t>(i));
  const Raster grey_back = decode_jpeg(jpeg_of(grey(16, 16, ramp), 100), "ramp.jpg");
  EXPECT_EQ(grey_back.channels, 1);
  for (std::size_t i = 0; i < ramp.size(); ++i)
    ASSERT_NEAR(grey_back.samples[i], ramp[i], 2) << "sample " << i;
}

TEST(Jpeg, FilesThatAreCutShortOrOfAnotherKindAreRefused) {
  std::string file = jpeg_of(four_colors(), 90);
  EXPECT_NO_THROW(decode_picture(file, "a.jpg"));
  EXPECT_THAT(error_text([&] { decode_picture(file.substr(0, file.size() - 8), "a.jpg"); }),
              HasSubstr("a.jpg: JPEG: "));
  EXPECT_THAT(error_text([&] { decode_picture(file.substr(0, 20), "a.jpg"); }), HasSubstr("a.jpg: JPEG: "));
  EXPECT_THAT(error_text([] { decode_picture("GIF89a", "a.gif"); }),
              "a.gif: is neither a PNG nor a JPEG picture");
  EXPECT_EQ(picture_format(file), PictureFormat::jpeg);
  EXPECT_EQ(picture_format(encode_png(four_colors())), PictureFormat::png);
  EXPECT_EQ(picture_format(""), PictureFormat::unknown);
  // 65500 texels a side, as a few bytes can't be.
  const std::size_t size = file.find("\xff\xc0") + 5;
  file.replace(size, 4, "\xff\xdc\xff\xdc");
  EXPECT_THAT(error_text([&] { decode_picture(file, "a.jpg"); }), HasSubstr("ends too early"));
}

TEST(PictureLoader, ReadsPicturesFromBesideTheModelAndTellsWhatIsMissing) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "maps");
  folder.write("maps/skin.png", encode_png(four_colors()));
  folder.write("bad.png", encode_png(four_colors()).substr(0, 40));
  const std::vector<Material> named{
      {"a", Vec4::Ones(), "maps\\skin.png"}, {"b", Vec4::Ones(), "bad.png"},  {"c", Vec4::Ones(), "none.png"},
      {"d", Vec4::Ones(), "maps\\skin.png"}, {"e", Vec4::Ones(), "none.png"}, {"f", Vec4::Ones(), ""}};
  std::vector<Material> materials = named;
  PictureLoader loader(folder.path());
  loader.load(materials);
  ASSERT_TRUE(materials[0].base_color_picture);
  EXPECT_EQ(*materials[0].base_color_picture, encode_png(four_colors()));
  EXPECT_EQ(materials[3].base_color_picture, materials[0].base_color_picture) << "read once";
  for (const std::size_t m : {1u, 2u, 4u, 5u}) EXPECT_FALSE(materials[m].base_color_picture);
  for (std::size_t m = 0; m < named.size(); ++m)
    EXPECT_EQ(materials[m].base_color_texture, named[m].base_color_texture) << "names stay";
  EXPECT_EQ(loader.step().changed, 2u) << "each once";
  EXPECT_THAT(loader.step().detail, HasSubstr("texture bad.png: the file ends too early"));
  EXPECT_THAT(loader.step().detail, HasSubstr("none.png: No such file"));
}

TEST(PictureLoader, KnownPicturesStayUnlessTheyAreDamaged) {
  std::vector<Material> materials(2);
  materials[0].normal_texture = "inside.png";
  materials[0].normal_picture = png_of(four_colors());
  materials[1].base_color_texture = "damaged.png";
  materials[1].base_color_picture = std::make_shared<const std::string>("GIF89a");
  const PictureBytes inside = materials[0].normal_picture;
  PictureLoader loader("nowhere");
  loader.load(materials);
  EXPECT_EQ(materials[0].normal_picture, inside);
  EXPECT_FALSE(materials[1].base_color_picture);
  EXPECT_EQ(loader.step().changed, 1u);
}

TEST(BaseColorTextures, AreThoseOfMaterialsWithPictures) {
  std::vector<Material> materials(3);
  materials[1].base_color_picture = materials[2].base_color_picture = png_of(four_colors());
  const BaseColorTextures textures(materials);
  EXPECT_EQ(textures.of(0), nullptr);
  ASSERT_NE(textures.of(1), nullptr);
  EXPECT_EQ(textures.of(1), textures.of(2));
  EXPECT_EQ(textures.of(k_no_index), nullptr);
  EXPECT_TRUE(BaseColorTextures({}).empty());
}

}  // namespace
}  // namespace recede::test
