// Knot spans, and the basis functions of one.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace recede::detail {

inline constexpr int k_most_degree = 25;

/// The span of the domain that holds t: knots[span] <= t < knots[span + 1]. The first or last one for what is
/// outside or at the end.
inline std::size_t find_span(const std::vector<double>& knots, int degree, std::size_t n_points, double t) {
  const auto begin = knots.begin() + degree, end = knots.begin() + static_cast<std::ptrdiff_t>(n_points);
  if (t >= *end) {
    // The last one that isn't empty.
    return static_cast<std::size_t>(std::lower_bound(begin, end, *end) - knots.begin()) - 1;
  }
  const auto after = std::upper_bound(begin, end, std::max(t, *begin));
  return static_cast<std::size_t>(after - knots.begin()) - 1;
}

/// The basis functions of a span at t with their first and second derivatives (algorithm A2.3).
struct BasisDerivatives {
  std::array<std::array<double, k_most_degree + 1>, 3> of;

  BasisDerivatives(const std::vector<double>& knots, int degree, std::size_t span, double t) {
    const auto p = static_cast<std::size_t>(degree);
    // Functions of the two degrees below, from which derivatives follow.
    std::array<double, k_most_degree + 1> values{}, one_below{}, two_below{};
    values[0] = 1;
    for (std::size_t d = 1; d <= p; ++d) {
      two_below = one_below;
      one_below = values;
      raise(knots, span, d, t, values);
    }
    of[0] = values;
    std::array<double, k_most_degree + 1> below_first{};
    differentiate(knots, span, p, one_below, of[1]);
    if (p < 2) {
      of[2] = {};
      return;
    }
    differentiate(knots, span, p - 1, two_below, below_first);
    differentiate(knots, span, p, below_first, of[2]);
  }

 private:
  using Values = std::array<double, k_most_degree + 1>;

  // From degree d - 1 to d.
  static void raise(const std::vector<double>& knots, std::size_t span, std::size_t d, double t,
                    Values& values) {
    double carried = 0;
    for (std::size_t r = 0; r < d; ++r) {
      const double right = knots[span + r + 1], left = knots[span + 1 + r - d];
      const double share = values[r] / (right - left);
      values[r] = carried + (right - t) * share;
      carried = (t - left) * share;
    }
    values[d] = carried;
  }

  // Of the functions of degree d, from values or derivatives of those of degree d - 1.
  static void differentiate(const std::vector<double>& knots, std::size_t span, std::size_t d,
                            const Values& below, Values& derivatives) {
    for (std::size_t r = 0; r <= d; ++r) {
      double value = 0;
      if (r > 0) value += below[r - 1] / (knots[span + r] - knots[span + r - d]);
      if (r < d) value -= below[r] / (knots[span + r + 1] - knots[span + r + 1 - d]);
      derivatives[r] = static_cast<double>(d) * value;
    }
  }
};

}  // namespace recede::detail
