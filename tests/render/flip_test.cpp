#include <recede/geometry/error.h>
#include <recede/render/image_difference.h>

#include <Eigen/LU>
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <cmath>
#include <random>

namespace recede {
namespace {

double flip(const Image& a, const Image& b, double pixels_per_degree = 67.02) {
  return compute_flip(a, b, {.pixels_per_degree = pixels_per_degree}).mean;
}

Image constant(const Rgb& color) { return Image(40, 30, color); }

Image noise(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> light(0, 1);
  Image image(width, height);
  for (Rgb& pixel : image.pixels) pixel = Rgb(light(random), light(random), light(random));
  return image;
}

// Filters and colours are floats: some roundings of 6e-8 each, raised to the power 0.7 near 0.
constexpr double k_rounding = 1e-5;

TEST(Flip, OfEqualImagesIsZeroEverywhere) {
  const ImageMeasure measure = compute_flip(noise(33, 21, 1), noise(33, 21, 1));
  EXPECT_EQ(measure.mean, 0);
  for (const float value : measure.map.samples) EXPECT_EQ(value, 0);
}

TEST(Flip, OfFullGreenAndFullBlueIsOne) {
  EXPECT_NEAR(flip(constant({0, 1, 0}), constant({0, 0, 1})), 1, k_rounding);
}

/// The error of two colours that fill their images, from their CIELAB values by the paper's formulas.
double error_of(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const auto distance = [](Eigen::Vector3d p, Eigen::Vector3d q) {
    for (Eigen::Vector3d* color : {&p, &q}) color->tail<2>() *= 0.01 * (*color)[0];
    return std::pow(std::abs(p[0] - q[0]) + (p - q).tail<2>().norm(), 0.7);
  };
  // CIELAB of sRGB's green and blue, D65.
  const double largest = distance({87.735, -86.183, 83.180}, {32.297, 79.188, -107.860});
  const double e = distance(a, b), bend = 0.4 * largest;
  return e < bend ? 0.95 * e / bend : 0.95 + 0.05 * (e - bend) / (largest - bend);
}

TEST(Flip, OfConstantImagesIsThatOfTheirLabColours) {
  const Eigen::Vector3d black(0, 0, 0), white(100, 0, 0);
  EXPECT_NEAR(error_of(black, white), 0.967, 5e-4);
  EXPECT_NEAR(flip(constant(Rgb::Zero()), constant(Rgb::Ones())), error_of(black, white), k_rounding);
  // Lightness 50 has the luminance ((50 + 16) / 116)^3, a difference of 50.
  const float middle = static_cast<float>(std::pow(66.0 / 116, 3));
  EXPECT_NEAR(flip(constant(Rgb::Constant(middle)), constant(Rgb::Ones())), error_of({50, 0, 0}, white),
              k_rounding);
  EXPECT_NEAR(flip(constant(Rgb::Zero()), constant(Rgb::Constant(0.001f))),
              error_of(black, {0.001 * std::pow(29 / 3.0, 3), 0, 0}), k_rounding)
      << "the straight part of CIELAB";
  // Published values of red have three decimals; they differ from ours by the white's last digit.
  EXPECT_NEAR(flip(constant({1, 0, 0}), constant(Rgb::Ones())), error_of({53.241, 80.092, 67.203}, white),
              1e-4);
  EXPECT_NEAR(flip(constant({1, 0, 0}), constant(Rgb::Zero())), error_of({53.241, 80.092, 67.203}, black),
              1e-4);
}

TEST(Flip, DoesNotDependOnTheOrder) {
  const Image a = noise(40, 30, 2), b = noise(40, 30, 3);
  EXPECT_EQ(compute_flip(a, b).map, compute_flip(b, a).map);
}

TEST(Flip, ClampsLightBeyondWhite) { EXPECT_EQ(flip(constant({4, -1, 1}), constant({1, 0, 1})), 0); }

/// The paper's filters in two dimensions, summed pixel by pixel in double precision. Image and result are
/// X, Y and Z as shares of the white's.
class PlainFlip {
 public:
  PlainFlip(const Image& image, double pixels_per_degree) : image_(image), ppd_(pixels_per_degree) {
    to_xyz_ << 0.4123866, 0.3575915, 0.1804505, 0.2126368, 0.7151830, 0.0721802, 0.0193306, 0.1191972,
        0.9503726;
    for (int row = 0; row < 3; ++row) to_xyz_.row(row) /= to_xyz_.row(row).sum();
  }

  Eigen::Vector3d lab(int x, int y) const {
    const Eigen::Vector3d opponent(filter(x, y, 0, 1, 0.0047, 0, 1), filter(x, y, 1, 1, 0.0053, 0, 1),
                                   filter(x, y, 2, 34.1, 0.04, 13.5, 0.025));
    Eigen::Vector3d xyz;
    xyz[1] = (opponent[0] + 16) / 116;
    xyz[0] = xyz[1] + opponent[1] / 500;
    xyz[2] = xyz[1] - opponent[2] / 200;
    const Eigen::Vector3d rgb = (to_xyz_.inverse() * xyz).cwiseMax(0.0).cwiseMin(1.0);
    Eigen::Vector3d f = to_xyz_ * rgb;
    for (double& t : f) t = t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116;
    return {116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])};
  }

  /// Lengths of the first and of the second derivative.
  std::pair<double, double> features(int x, int y) const {
    const double sigma = 0.5 * 0.082 * ppd_;
    const int radius = static_cast<int>(std::ceil(3 * sigma));
    const auto derivative = [&](bool along_x, bool second) {
      double positive = 0, negative = 0, sum_positive = 0, sum_negative = 0;
      for (int j = -radius; j <= radius; ++j) {
        for (int i = -radius; i <= radius; ++i) {
          const double t = along_x ? i : j, gaussian = std::exp(-(i * i + j * j) / (2 * sigma * sigma));
          const double weight = second ? (t * t / (sigma * sigma) - 1) * gaussian : -t * gaussian;
          const double value = (opponent_at(x + i, y + j)[0] + 16) / 116;
          (weight > 0 ? positive : negative) += std::abs(weight);
          (weight > 0 ? sum_positive : sum_negative) += weight * value;
        }
      }
      return sum_positive / positive + sum_negative / negative;
    };
    return {std::hypot(derivative(true, false), derivative(false, false)),
            std::hypot(derivative(true, true), derivative(false, true))};
  }

 private:
  Eigen::Vector3d opponent_at(int x, int y) const {
    const Rgb& pixel = image_.at(std::clamp(x, 0, image_.width - 1), std::clamp(y, 0, image_.height - 1));
    const Eigen::Vector3d xyz = to_xyz_ * pixel.cast<double>();
    return {116 * xyz[1] - 16, 500 * (xyz[0] - xyz[1]), 200 * (xyz[1] - xyz[2])};
  }

  double filter(int x, int y, int channel, double a1, double b1, double a2, double b2) const {
    const double pi = std::acos(-1.0);
    const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * pi * pi)) * ppd_));
    double sum = 0, weights = 0;
    for (int j = -radius; j <= radius; ++j) {
      for (int i = -radius; i <= radius; ++i) {
        const double square = (i * i + j * j) / (ppd_ * ppd_);
        const double weight = a1 * std::sqrt(pi / b1) * std::exp(-pi * pi * square / b1) +
                              a2 * std::sqrt(pi / b2) * std::exp(-pi * pi * square / b2);
        sum += weight * opponent_at(x + i, y + j)[channel];
        weights += weight;
      }
    }
    return sum / weights;
  }

  const Image& image_;
  double ppd_;
  Eigen::Matrix3d to_xyz_;
};

TEST(Flip, AgreesWithTheFormulasSummedPixelByPixel) {
  for (const double pixels_per_degree : {67.02, 20.0}) {
    Image a = noise(25, 19, 4), b = a;
    for (int y = 3; y < 9; ++y) {
      for (int x = 5; x < 22; ++x) b.at(x, y) = Rgb(0.9f, 0.1f, 0.3f);
    }
    const FloatRaster map = compute_flip(a, b, {.pixels_per_degree = pixels_per_degree}).map;
    const PlainFlip plain_a(a, pixels_per_degree), plain_b(b, pixels_per_degree);
    for (int y = 0; y < a.height; y += 3) {
      for (int x = 0; x < a.width; x += 2) {
        const auto [edge_a, point_a] = plain_a.features(x, y);
        const auto [edge_b, point_b] = plain_b.features(x, y);
        const double feature =
            std::sqrt(std::max(std::abs(edge_a - edge_b), std::abs(point_a - point_b)) / std::sqrt(2.0));
        const double color = error_of(plain_a.lab(x, y), plain_b.lab(x, y));
        EXPECT_NEAR(map.at(x, y), std::pow(color, 1 - feature), 1e-4)  // the matrices have 7 digits
            << x << ' ' << y;
      }
    }
  }
}

TEST(Flip, FinePatternsFadeWithDistance) {
  Image board(64, 64);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) board.at(x, y) = Rgb::Constant((x + y) % 2 == 0 ? 1.0f : 0.0f);
  }
  const Image grey(64, 64, Rgb::Constant(0.5f));
  double before = 1;
  for (const double pixels_per_degree : {10.0, 20.0, 40.0, 80.0}) {
    const double now = flip(board, grey, pixels_per_degree);
    EXPECT_LT(now, before) << pixels_per_degree;
    before = now;
  }
  EXPECT_LT(before, 0.1) << "a board of pixels looks grey from afar";
}

TEST(Flip, AnEdgeCountsMoreThanTheSameStepOfAWholeImage) {
  Image dark(60, 40, Rgb::Constant(0.2f)), edge = dark;
  for (int y = 0; y < 40; ++y) {
    for (int x = 30; x < 60; ++x) edge.at(x, y) = Rgb::Constant(0.3f);
  }
  const FloatRaster map = compute_flip(dark, edge).map;
  const double flat = flip(dark, Image(60, 40, Rgb::Constant(0.3f)));
  EXPECT_NEAR(map.at(59, 20), flat, k_rounding) << "away from the edge";
  EXPECT_GT(map.at(33, 20), flat * 1.1);
}

TEST(Flip, SeesOnlyWhatIsInsideTheMask) {
  const Image a = noise(40, 30, 5), b = noise(40, 30, 6);
  ImageMask mask{40, 30, std::vector<std::uint8_t>(1200, 0)};
  for (int y = 8; y < 20; ++y) {
    for (int x = 0; x < 25; ++x) mask.inside[static_cast<std::size_t>(y * 40 + x)] = 1;
  }
  Image other = b;
  for (std::size_t i = 0; i < other.pixels.size(); ++i) {
    if (mask.inside[i] == 0) other.pixels[i] = Rgb(0, 1, 0);
  }
  const ImageMeasure measure = compute_flip(a, b, {}, mask);
  EXPECT_EQ(measure.map, compute_flip(a, other, {}, mask).map);
  double sum = 0;
  for (std::size_t i = 0; i < other.pixels.size(); ++i) {
    if (mask.inside[i] == 0) {
      EXPECT_EQ(measure.map.samples[i], 0);
    }
    sum += measure.map.samples[i];
  }
  EXPECT_NEAR(measure.mean, sum / (12 * 25), 1e-12);

  const ImageMask all{40, 30, std::vector<std::uint8_t>(1200, 1)};
  EXPECT_NEAR(compute_flip(a, b, {}, all).mean, compute_flip(a, b).mean, k_rounding);
  const Image grey = constant(Rgb::Constant(0.2f)), light = constant(Rgb::Constant(0.3f));
  const FloatRaster flat = compute_flip(grey, light, {}, mask).map;
  const double expected = flip(grey, light);
  for (std::size_t i = 0; i < 1200; ++i) {
    // The square root of the features turns a rounding of 1e-7 into 3e-4.
    if (mask.inside[i] == 1) {
      EXPECT_NEAR(flat.samples[i], expected, 3e-4) << "the mask's border is no edge";
    }
  }
}

TEST(Flip, HasTheSameBytesForAnyNumberOfThreads) {
  const Image a = noise(150, 90, 7), b = noise(150, 90, 8);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const ImageMeasure alone = compute_flip(a, b);
  const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);
  EXPECT_EQ(compute_flip(a, b).map, alone.map);
  EXPECT_EQ(compute_flip(a, b).mean, alone.mean);
}

TEST(Flip, TakesImagesOfOnePixel) {
  EXPECT_NEAR(flip(Image(1, 1), Image(1, 1, Rgb::Ones())), 0.967, 5e-4);
  EXPECT_EQ(flip(Image(1, 7), Image(1, 7), 1000), 0);
}

TEST(Flip, RefusesImpossibleViewers) {
  for (const double pixels_per_degree : {0.0, -1.0, 0.5, 1e4, std::nan("")})
    EXPECT_THROW(flip(Image(2, 2), Image(2, 2), pixels_per_degree), OptionError) << pixels_per_degree;
}

}  // namespace
}  // namespace recede
