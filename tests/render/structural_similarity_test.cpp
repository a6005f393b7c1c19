#include <recede/render/image_difference.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace recede {
namespace {

/// Luma, which is the value of the encoded grey.
double value_of(const Image& image, int x, int y) {
  return static_cast<double>(encode_srgb(image.at(x, y).x()));
}

Image grey_noise(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> light(0, 1);
  Image image(width, height);
  for (Rgb& pixel : image.pixels) pixel = Rgb::Constant(light(random));
  return image;
}

constexpr double k_c1 = 1e-4, k_c2 = 9e-4;

/// Equation 13 with the window's sums written out; `counts(x, y)` says what the window sees.
template <typename Counts>
double plain_ssim(const Image& a, const Image& b, int x, int y, const Counts& counts) {
  double weights = 0, mean_a = 0, mean_b = 0, variance_a = 0, variance_b = 0, covariance = 0;
  const auto sum = [&](const auto& add) {
    for (int j = -5; j <= 5; ++j) {
      for (int i = -5; i <= 5; ++i) {
        if (counts(x + i, y + j)) add(x + i, y + j, std::exp(-(i * i + j * j) / 4.5));
      }
    }
  };
  sum([&](int u, int v, double weight) {
    weights += weight;
    mean_a += weight * value_of(a, u, v);
    mean_b += weight * value_of(b, u, v);
  });
  mean_a /= weights;
  mean_b /= weights;
  sum([&](int u, int v, double weight) {
    const double from_a = value_of(a, u, v) - mean_a, from_b = value_of(b, u, v) - mean_b;
    variance_a += weight / weights * from_a * from_a;
    variance_b += weight / weights * from_b * from_b;
    covariance += weight / weights * from_a * from_b;
  });
  return (2 * mean_a * mean_b + k_c1) * (2 * covariance + k_c2) /
         ((mean_a * mean_a + mean_b * mean_b + k_c1) * (variance_a + variance_b + k_c2));
}

// The map holds floats; sums are doubles.
constexpr double k_rounding = 1e-6;

TEST(StructuralSimilarity, OfEqualImagesIsOne) {
  const Image image = grey_noise(20, 30, 1);
  EXPECT_EQ(compute_ssim(image, image).mean, 1);
}

TEST(StructuralSimilarity, OfConstantImagesComparesTheirMeans) {
  EXPECT_NEAR(compute_ssim(Image(16, 12), Image(16, 12, Rgb::Ones())).mean, k_c1 / (1 + k_c1), 1e-9);
  const Image a(16, 12, Rgb::Constant(decode_srgb(0.25f))), b(16, 12, Rgb::Constant(decode_srgb(0.5f)));
  EXPECT_NEAR(compute_ssim(a, b).mean, (0.25 + k_c1) / (0.3125 + k_c1), k_rounding);
}

TEST(StructuralSimilarity, OfInvertedImagesIsNegative) {
  Image image = grey_noise(30, 30, 2), inverted = image;
  for (Rgb& pixel : inverted.pixels) pixel = Rgb::Constant(decode_srgb(1 - encode_srgb(pixel.x())));
  EXPECT_LT(compute_ssim(image, inverted).mean, -0.5);
}

TEST(StructuralSimilarity, LumaWeighsColoursAsTelevisionDoes) {
  const Image green(11, 11, Rgb(0, 1, 0)), black(11, 11);
  EXPECT_NEAR(compute_ssim(green, black).mean, k_c1 / (0.587 * 0.587 + k_c1), k_rounding);
}

TEST(StructuralSimilarity, AgreesWithTheFormulaSummedPixelByPixel) {
  const Image a = grey_noise(23, 17, 3), b = grey_noise(23, 17, 4);
  const ImageMeasure measure = compute_ssim(a, b);
  double sum = 0;
  for (int y = 5; y < 12; ++y) {
    for (int x = 5; x < 18; ++x) {
      const double expected = plain_ssim(a, b, x, y, [](int, int) { return true; });
      EXPECT_NEAR(measure.map.at(x, y), expected, k_rounding) << x << ' ' << y;
      sum += expected;
    }
  }
  EXPECT_NEAR(measure.mean, sum / (7 * 13), k_rounding) << "whole windows only";
  EXPECT_EQ(compute_ssim(b, a).mean, measure.mean);
}

TEST(StructuralSimilarity, SmallImagesCountWithTheWindowsThatReachBeyond) {
  EXPECT_NEAR(compute_ssim(Image(4, 3), Image(4, 3, Rgb::Ones())).mean, k_c1 / (1 + k_c1), 1e-9);
}

TEST(StructuralSimilarity, WindowsSeeOnlyWhatIsInsideTheMask) {
  const Image a = grey_noise(26, 22, 5), b = grey_noise(26, 22, 6);
  ImageMask mask{26, 22, std::vector<std::uint8_t>(26 * 22, 0)};
  const auto inside = [](int x, int y) { return x >= 6 && x < 15 && y >= 7 && y < 16; };
  Image other = b;
  double sum = 0;
  for (int y = 0; y < 22; ++y) {
    for (int x = 0; x < 26; ++x) {
      mask.inside[static_cast<std::size_t>(y * 26 + x)] = inside(x, y) ? 1 : 0;
      if (!inside(x, y)) other.at(x, y) = Rgb::Ones();
      if (inside(x, y)) sum += plain_ssim(a, b, x, y, inside);
    }
  }
  const ImageMeasure measure = compute_ssim(a, b, mask);
  EXPECT_NEAR(measure.mean, sum / 81, k_rounding);
  EXPECT_EQ(measure.map, compute_ssim(a, other, mask).map);
  EXPECT_EQ(measure.map.at(0, 0), 1);
}

}  // namespace
}  // namespace recede
