#include <recede/render/detail/image_pair.h>

#include <cmath>

namespace recede {
namespace {

using detail::PlaneSize;
using Plane = std::vector<double>;  // variances are small differences of large numbers

constexpr int k_window_radius = 5;
constexpr double k_window_sigma = 1.5;
constexpr double k_c1 = 0.01 * 0.01, k_c2 = 0.03 * 0.03;  // of values from 0 to 1

detail::Taps<double> window_taps() {
  detail::Taps<double> taps;
  double sum = 0;
  for (int i = -k_window_radius; i <= k_window_radius; ++i)
    sum += taps.emplace_back(std::exp(-i * i / (2 * k_window_sigma * k_window_sigma)));
  for (double& tap : taps) tap /= sum;
  return taps;
}

/// Means over the window at each pixel, of what is inside the mask.
class Window {
 public:
  Window(const PlaneSize& size, const ImageMask& mask)
      : size_(size), taps_(window_taps()), inside_(detail::weights_of<double>(mask)) {
    if (!inside_.empty()) covered_ = blur(inside_);
  }

  Plane mean(Plane plane) const {
    detail::apply_weights(inside_, plane);
    Plane result = blur(plane);
    for (std::size_t i = 0; i < inside_.size(); ++i) {
      if (inside_[i] > 0) result[i] /= covered_[i];
    }
    return result;
  }

 private:
  Plane blur(const Plane& plane) const {
    return detail::filter_columns(size_, detail::filter_rows(size_, plane, taps_), taps_);
  }

  PlaneSize size_;
  detail::Taps<double> taps_;
  Plane inside_, covered_;
};

Plane luma_of(const Image& image) {
  Plane plane(image.pixels.size());
  detail::for_each_row(detail::size_of(image), [&](int, std::size_t first) {
    for (std::size_t i = first; i < first + static_cast<std::size_t>(image.width); ++i)
      plane[i] = detail::luma(image.pixels[i]);
  });
  return plane;
}

Plane product(const Plane& a, const Plane& b) {
  Plane result(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) result[i] = a[i] * b[i];
  return result;
}

}  // namespace

ImageMeasure compute_ssim(const Image& a, const Image& b, const ImageMask& mask) {
  detail::require_comparable(a, b, mask);
  const PlaneSize size = detail::size_of(a);
  const Window window(size, mask);
  const Plane luma_a = luma_of(a), luma_b = luma_of(b);
  const Plane mean_a = window.mean(luma_a), mean_b = window.mean(luma_b);
  const Plane square_a = window.mean(product(luma_a, luma_a)),
              square_b = window.mean(product(luma_b, luma_b));
  const Plane mixed = window.mean(product(luma_a, luma_b));
  ImageMeasure result{.map = detail::empty_map(a, 1)};
  for (std::size_t i = 0; i < mixed.size(); ++i) {
    if (!mask.counts(i)) continue;
    const double product_of_means = mean_a[i] * mean_b[i];
    const double squares_of_means = mean_a[i] * mean_a[i] + mean_b[i] * mean_b[i];
    const double covariance = mixed[i] - product_of_means;
    const double variances = square_a[i] + square_b[i] - squares_of_means;
    result.map.samples[i] = static_cast<float>((2 * product_of_means + k_c1) * (2 * covariance + k_c2) /
                                               ((squares_of_means + k_c1) * (variances + k_c2)));
  }
  result.mean = detail::mean_inside(result.map, mask, k_window_radius)
                    .value_or(detail::mean_inside(result.map, mask).value());
  return result;
}

}  // namespace recede
