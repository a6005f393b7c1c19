// FLIP for pictures of low dynamic range: Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom and Fairchild
// 2020, "FLIP: a difference evaluator for alternating images", section 4. Written from the paper's formulas.
#include <recede/geometry/error.h>
#include <recede/render/detail/image_pair.h>

#include <Eigen/LU>

#include <array>
#include <cmath>
#include <numbers>

namespace recede {
namespace {

using detail::filter_columns;
using detail::filter_rows;
using detail::PlaneSize;
using Plane = std::vector<float>;
using Taps = detail::Taps<float>;

constexpr double k_pi = std::numbers::pi;

// ---- colours ----

/// From linear light to X, Y and Z, each as a share of the white's, by the chromaticities of sRGB's primaries
/// (IEC 61966-2-1). As every row sums to 1, the white itself isn't needed.
Eigen::Matrix3f relative_xyz_matrix() {
  Eigen::Matrix3d primaries;
  primaries << 0.64, 0.30, 0.15,  // x of red, green, blue
      0.33, 0.60, 0.06,           // y
      0.03, 0.10, 0.79;           // z = 1 - x - y
  const Eigen::Vector3d white(0.3127 / 0.3290, 1, (1 - 0.3127 - 0.3290) / 0.3290);
  const Eigen::Vector3d scales = primaries.inverse() * white;
  const Eigen::Matrix3d to_xyz = primaries * scales.asDiagonal();
  return (white.cwiseInverse().asDiagonal() * to_xyz).cast<float>();
}

const Eigen::Matrix3f k_to_xyz = relative_xyz_matrix();
const Eigen::Matrix3f k_from_xyz = k_to_xyz.inverse();

Rgb clamped(const Rgb& color) { return color.cwiseMax(0.0f).cwiseMin(1.0f); }

/// The function of CIELAB that makes steps even.
float compress(float t) {
  constexpr float k_delta = 6.0f / 29.0f;
  return t > k_delta * k_delta * k_delta ? std::cbrt(t) : t / (3 * k_delta * k_delta) + 4.0f / 29.0f;
}

/// CIELAB with a and b scaled by lightness: colours look stronger in brighter light (Hunt).
Eigen::Vector3f hunt_lab(const Rgb& linear) {
  const Eigen::Vector3f xyz = k_to_xyz * linear;
  const float x = compress(xyz.x()), y = compress(xyz.y()), z = compress(xyz.z());
  const float lightness = 116 * y - 16, hunt = 0.01f * lightness;
  return {lightness, hunt * 500 * (x - y), hunt * 200 * (y - z)};
}

/// HyAB (Abasi et al. 2020): a sum for lightness, Euclidean for hue and chroma.
float hyab_distance(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  const Eigen::Vector3f d = a - b;
  return std::abs(d.x()) + std::sqrt(d.y() * d.y() + d.z() * d.z());
}

constexpr float k_color_exponent = 0.7f;

/// The distance to the power above, mapped to 0..1: up to the share `k_bend` of the largest one by a steep
/// line, the rest by a flat one.
float color_error(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  constexpr float k_bend = 0.4f, k_value_at_bend = 0.95f;
  static const float largest =
      std::pow(hyab_distance(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), k_color_exponent);
  const float error = std::pow(hyab_distance(a, b), k_color_exponent), bend = k_bend * largest;
  if (error < bend) return k_value_at_bend / bend * error;
  return std::min(1.0f, k_value_at_bend + (error - bend) / (largest - bend) * (1 - k_value_at_bend));
}

// ---- the eye's sensitivity to contrast ----

/// A Gaussian in the spectrum, weight * exp(-width f^2), with f in cycles per degree.
struct SpectralGaussian {
  double weight, width;
};
using ContrastSensitivity = std::array<SpectralGaussian, 2>;
// Of lightness, red against green, and blue against yellow.
constexpr std::array<ContrastSensitivity, 3> k_sensitivities{
    {{{{1, 0.0047}, {0, 1e-5}}}, {{{1, 0.0053}, {0, 1e-5}}}, {{{34.1, 0.04}, {13.5, 0.025}}}}};
constexpr double k_widest = 0.04;

/// A filter that is a sum of some that serve along both axes.
using FilterSum = std::vector<Taps>;

/// The sum of weight * sqrt(pi / width) * exp(-pi^2 x^2 / width), x the distance in degrees, with sum 1.
FilterSum sensitivity_filter(const ContrastSensitivity& sensitivity, double pixels_per_degree) {
  const double sigma = std::sqrt(k_widest / (2 * k_pi * k_pi));
  const int radius = static_cast<int>(std::ceil(3 * sigma * pixels_per_degree));
  std::vector<std::vector<double>> terms;
  double total = 0;
  for (const SpectralGaussian& gaussian : sensitivity) {
    if (gaussian.weight == 0) continue;
    // The factor of the square is spread over both axes.
    const double factor = std::sqrt(gaussian.weight * std::sqrt(k_pi / gaussian.width));
    std::vector<double>& taps = terms.emplace_back();
    double sum = 0;
    for (int i = -radius; i <= radius; ++i) {
      const double x = i / pixels_per_degree;
      sum += taps.emplace_back(factor * std::exp(-k_pi * k_pi * x * x / gaussian.width));
    }
    total += sum * sum;
  }
  FilterSum filter;
  for (const std::vector<double>& term : terms) {
    Taps& taps = filter.emplace_back();
    for (const double tap : term) taps.push_back(static_cast<float>(tap / std::sqrt(total)));
  }
  return filter;
}

Plane apply(const FilterSum& filter, const PlaneSize& size, const Plane& plane) {
  Plane sum;
  for (const Taps& taps : filter) {
    Plane term = filter_columns(size, filter_rows(size, plane, taps), taps);
    if (sum.empty()) {
      sum = std::move(term);
    } else {
      detail::add_scaled(1.0f, term.data(), sum.data(), sum.size());
    }
  }
  return sum;
}

// ---- edges and points ----

/// A Gaussian along an axis, and its first and second derivative.
struct FeatureTaps {
  Taps smooth, edge, point;
};

/// Positive taps with sum 1, and negative ones with sum -1.
Taps balanced(const std::vector<double>& values) {
  double positive = 0, negative = 0;
  for (const double value : values) (value > 0 ? positive : negative) += std::abs(value);
  Taps taps;
  for (const double value : values)
    taps.push_back(static_cast<float>(value / (value > 0 || negative == 0 ? positive : negative)));
  return taps;
}

FeatureTaps feature_taps(double pixels_per_degree) {
  constexpr double k_feature_width = 0.082;  // degrees
  const double sigma = 0.5 * k_feature_width * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  std::vector<double> smooth, edge, point;
  for (int x = -radius; x <= radius; ++x) {
    const double gaussian = std::exp(-x * x / (2 * sigma * sigma));
    smooth.push_back(gaussian);
    edge.push_back(-x * gaussian);
    point.push_back((x * x / (sigma * sigma) - 1) * gaussian);
  }
  return {balanced(smooth), balanced(edge), balanced(point)};
}

/// Derivatives of a plane along both axes.
struct Features {
  Plane edge_x, edge_y, point_x, point_y;
};

Features derivatives_of(const Plane& plane, const PlaneSize& size, const FeatureTaps& taps) {
  const Plane smooth = filter_rows(size, plane, taps.smooth);
  return {.edge_x = filter_columns(size, filter_rows(size, plane, taps.edge), taps.smooth),
          .edge_y = filter_columns(size, smooth, taps.edge),
          .point_x = filter_columns(size, filter_rows(size, plane, taps.point), taps.smooth),
          .point_y = filter_columns(size, smooth, taps.point)};
}

float feature_difference(const Features& a, const Features& b, std::size_t i) {
  const auto length = [i](const Plane& x, const Plane& y) { return std::sqrt(x[i] * x[i] + y[i] * y[i]); };
  const float edge = std::abs(length(a.edge_x, a.edge_y) - length(b.edge_x, b.edge_y));
  const float point = std::abs(length(a.point_x, a.point_y) - length(b.point_x, b.point_y));
  // To the power 0.5. A step from black to white along a diagonal has the length of sqrt(2) at most.
  return std::sqrt(std::max(edge, point) / std::numbers::sqrt2_v<float>);
}

// ---- both together ----

/// Filters at every pixel, of what is inside the mask.
class Eye {
 public:
  Eye(const PlaneSize& size, const ImageMask& mask, double pixels_per_degree)
      : size_(size),
        inside_(detail::weights_of<float>(mask)),
        feature_taps_(feature_taps(pixels_per_degree)) {
    for (std::size_t c = 0; c < 3; ++c) {
      filters_[c] = sensitivity_filter(k_sensitivities[c], pixels_per_degree);
      if (!inside_.empty()) covered_[c] = apply(filters_[c], size_, inside_);
    }
    if (!inside_.empty()) features_of_mask_ = derivatives_of(inside_, size_, feature_taps_);
  }

  struct Seen {
    std::vector<Eigen::Vector3f> colors;  ///< filtered, as `hunt_lab`
    Features features;
  };

  Seen look_at(const Image& image) const {
    // Y, X - Y and Y - Z: the opponent space YCxCz but for factors and a constant, which filters pass on.
    std::array<Plane, 3> planes;
    for (Plane& plane : planes) plane.resize(image.pixels.size());
    for_each_pixel([&](std::size_t i) {
      const Eigen::Vector3f xyz = k_to_xyz * clamped(image.pixels[i]);
      planes[0][i] = xyz.y();
      planes[1][i] = xyz.x() - xyz.y();
      planes[2][i] = xyz.y() - xyz.z();
    });
    Seen seen;
    seen.features = features_of(planes[0]);
    for (std::size_t c = 0; c < 3; ++c) planes[c] = filtered(std::move(planes[c]), c);
    seen.colors.resize(image.pixels.size());
    for_each_pixel([&](std::size_t i) {
      const float y = planes[0][i];
      const Rgb color = k_from_xyz * Eigen::Vector3f(y + planes[1][i], y, y - planes[2][i]);
      seen.colors[i] = hunt_lab(clamped(color));
    });
    return seen;
  }

  template <typename Work>
  void for_each_pixel(Work&& work) const {
    detail::for_each_row(size_, [&](int, std::size_t first) {
      for (std::size_t i = first; i < first + static_cast<std::size_t>(size_.width); ++i) work(i);
    });
  }

 private:
  Plane filtered(Plane plane, std::size_t channel) const {
    detail::apply_weights(inside_, plane);
    Plane result = apply(filters_[channel], size_, plane);
    for (std::size_t i = 0; i < inside_.size(); ++i) {
      if (inside_[i] > 0) result[i] /= covered_[channel][i];
    }
    return result;
  }

  /// Outside the mask every pixel sees its own value: there it sees no edge.
  Features features_of(Plane plane) const {
    detail::apply_weights(inside_, plane);
    Features features = derivatives_of(plane, size_, feature_taps_);
    for (Plane Features::*part :
         {&Features::edge_x, &Features::edge_y, &Features::point_x, &Features::point_y}) {
      for (std::size_t i = 0; i < inside_.size(); ++i)
        (features.*part)[i] -= plane[i] * (features_of_mask_.*part)[i];
    }
    return features;
  }

  PlaneSize size_;
  Plane inside_;  ///< 1 inside the mask, 0 outside; empty without a mask
  std::array<FilterSum, 3> filters_;
  std::array<Plane, 3> covered_;  ///< the share of each filter that lies inside
  FeatureTaps feature_taps_;
  Features features_of_mask_;
};

}  // namespace

ImageMeasure compute_flip(const Image& a, const Image& b, const FlipOptions& options, const ImageMask& mask) {
  detail::require_comparable(a, b, mask);
  if (!(options.pixels_per_degree >= 1 && options.pixels_per_degree <= 1000))
    throw OptionError("pixels per degree must lie between 1 and 1000");
  const Eye eye(detail::size_of(a), mask, options.pixels_per_degree);
  const Eye::Seen seen_a = eye.look_at(a), seen_b = eye.look_at(b);
  ImageMeasure result{.map = detail::empty_map(a, 0)};
  eye.for_each_pixel([&](std::size_t i) {
    if (!mask.counts(i)) return;
    const float color = color_error(seen_a.colors[i], seen_b.colors[i]);
    const float feature = feature_difference(seen_a.features, seen_b.features, i);
    result.map.samples[i] = std::pow(color, 1 - feature);
  });
  result.mean = detail::mean_inside(result.map, mask).value();
  return result;
}

}  // namespace recede
