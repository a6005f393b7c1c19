#include <recede/geometry/error.h>
#include <recede/render/image_difference.h>

#include <gtest/gtest.h>

#include <cmath>

namespace recede {
namespace {

Rgb encoded(float red, float green, float blue) {
  return {decode_srgb(red), decode_srgb(green), decode_srgb(blue)};
}

TEST(ImageDifference, EqualImagesDifferByNothing) {
  const Image image(4, 3, encoded(0.2f, 0.4f, 0.6f));
  const ImageDifference difference = compare_images(image, image);
  EXPECT_EQ(difference.rmse, 0);
  EXPECT_EQ(difference.max, 0);
  EXPECT_EQ(difference.changed_share, 0);
}

TEST(ImageDifference, KnownStepsGiveKnownNumbers) {
  Image a(2, 2, encoded(0.5f, 0.5f, 0.5f)), b = a;
  b.at(0, 0) = encoded(0.8f, 0.5f, 0.5f);               // one channel by 0.3
  b.at(1, 1) = encoded(0.5f, 0.5f + 0.5f / 255, 0.5f);  // below the smallest step of a screen
  const ImageDifference difference = compare_images(a, b);
  EXPECT_NEAR(difference.rmse, std::sqrt((0.09 + 0.25 / 255 / 255) / 12), 1e-6);
  EXPECT_NEAR(difference.max, 0.3, 1e-6);
  EXPECT_DOUBLE_EQ(difference.changed_share, 0.25);
  EXPECT_NEAR(difference.magnitudes[0], 0.3, 1e-6);
}

TEST(ImageDifference, BlackAndWhiteDifferByOne) {
  const ImageDifference difference = compare_images(Image(3, 3), Image(3, 3, Rgb::Ones()));
  EXPECT_NEAR(difference.rmse, 1, 1e-6);
  EXPECT_EQ(difference.changed_share, 1);
}

TEST(ImageDifference, AShrunkHeatMapKeepsTheLargestOfEachBlock) {
  Image a(4, 4), b(4, 4);
  b.at(3, 0) = Rgb::Ones();
  const Image map = heat_map(compare_images(a, b), 1.0, 2);
  EXPECT_EQ(map.width, 2);
  EXPECT_TRUE(map.at(1, 0).isApprox(heat_map_color(1), 1e-5f));
  EXPECT_TRUE(map.at(0, 0).isApprox(heat_map_color(0), 1e-5f));
}

TEST(ImageDifference, HeatMapColoursGetLighterAllTheWay) {
  const auto lightness = [](double share) {
    return heat_map_color(share).dot(Rgb(0.2126f, 0.7152f, 0.0722f));
  };
  for (int i = 0; i < 50; ++i) EXPECT_LT(lightness(i / 50.0), lightness((i + 1) / 50.0)) << i;
}

TEST(ImageDifference, ImagesOfDifferentSizesAreRefused) {
  EXPECT_THROW(compare_images(Image(2, 3), Image(3, 2)), InputError);
}

}  // namespace
}  // namespace recede
