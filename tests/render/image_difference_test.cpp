#include "input_errors.h"
#include <recede/render/image_difference.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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
  EXPECT_NEAR(difference.magnitudes.samples[0], 0.3, 1e-6);
}

TEST(ImageDifference, BlackAndWhiteDifferByOne) {
  const ImageDifference difference = compare_images(Image(3, 3), Image(3, 3, Rgb::Ones()));
  EXPECT_NEAR(difference.rmse, 1, 1e-6);
  EXPECT_EQ(difference.changed_share, 1);
}

TEST(ImageDifference, PeakSignalToNoiseRatioIsInDecibels) {
  const auto psnr = [](float step) {
    return compare_images(Image(3, 2, encoded(0.2f, 0.2f, 0.2f)),
                          Image(3, 2, encoded(0.2f + step, 0.2f + step, 0.2f + step)))
        .psnr;
  };
  EXPECT_NEAR(psnr(0.1f), 20, 1e-4);  // differences of floats near 0.3, to 6e-8 of 0.1
  EXPECT_NEAR(psnr(0.01f), 40, 1e-3);
  EXPECT_EQ(psnr(0), std::numeric_limits<double>::infinity());
  EXPECT_NEAR(compare_images(Image(3, 3), Image(3, 3, Rgb::Ones())).psnr, 0, 1e-5);
}

TEST(ImageDifference, AMaskLeavesOutWhatLiesOutside) {
  Image a(3, 2, encoded(0.5f, 0.5f, 0.5f)), b = a, painted(3, 2);
  b.at(0, 0) = encoded(0.8f, 0.5f, 0.5f);
  b.at(2, 1) = Rgb::Zero();
  painted.at(0, 0) = painted.at(1, 0) = Rgb::Ones();
  painted.at(0, 1) = encoded(128 / 255.0f, 128 / 255.0f, 128 / 255.0f);
  painted.at(1, 1) = encoded(127 / 255.0f, 127 / 255.0f, 127 / 255.0f);
  const ImageMask mask = mask_of(painted);
  EXPECT_EQ(mask.inside, (std::vector<std::uint8_t>{1, 1, 0, 1, 0, 0}));
  const ImageDifference difference = compare_images(a, b, mask);
  EXPECT_NEAR(difference.rmse, std::sqrt(0.09 / 9), 1e-6);
  EXPECT_NEAR(difference.max, 0.3, 1e-6);
  EXPECT_DOUBLE_EQ(difference.changed_share, 1 / 3.0);
  EXPECT_EQ(difference.magnitudes.at(2, 1), 0);
}

TEST(ImageDifference, AShrunkHeatMapKeepsTheLargestOfEachBlock) {
  Image a(4, 4), b(4, 4);
  b.at(3, 0) = Rgb::Ones();
  const Image map = heat_map(compare_images(a, b).magnitudes, 1.0, 2);
  EXPECT_EQ(map.width, 2);
  EXPECT_TRUE(map.at(1, 0).isApprox(heat_map_color(1), 1e-5f));
  EXPECT_TRUE(map.at(0, 0).isApprox(heat_map_color(0), 1e-5f));
  const Image one = heat_map(compare_images(a, b).magnitudes, 1.0, std::numeric_limits<int>::max());
  ASSERT_EQ(one.pixels.size(), 1u);
  EXPECT_TRUE(one.at(0, 0).isApprox(heat_map_color(1), 1e-5f));
}

TEST(ImageDifference, HeatMapColoursGetLighterAllTheWay) {
  const auto lightness = [](double share) {
    return heat_map_color(share).dot(Rgb(0.2126f, 0.7152f, 0.0722f));
  };
  for (int i = 0; i < 50; ++i) EXPECT_LT(lightness(i / 50.0), lightness((i + 1) / 50.0)) << i;
}

TEST(ImageDifference, WhatCannotBeComparedIsRefusedByAllMeasures) {
  const auto refusal = [](const Image& a, const Image& b, const ImageMask& mask) {
    const std::string text = test::error_text([&] { compare_images(a, b, mask); });
    EXPECT_EQ(test::error_text([&] { compute_ssim(a, b, mask); }), text);
    EXPECT_EQ(test::error_text([&] { compute_flip(a, b, {}, mask); }), text);
    EXPECT_THROW(compare_images(a, b, mask), InputError);
    return text;
  };
  EXPECT_EQ(refusal(Image(2, 3), Image(3, 2), {}),
            "images of different sizes can't be compared: 2 x 3 and 3 x 2 pixels");
  EXPECT_EQ(refusal({}, {}, {}), "images without pixels can't be compared");
  EXPECT_EQ(refusal(Image(2, 2), Image(2, 2), mask_of(Image(2, 1))),
            "the mask has 2 x 1 pixels, the images 2 x 2");
  EXPECT_EQ(refusal(Image(2, 2), Image(2, 2), mask_of(Image(2, 2))), "the mask leaves no pixel");
}

}  // namespace
}  // namespace recede
