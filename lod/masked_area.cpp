#include <recede/lod/detail/masked_area.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace recede::detail {

namespace {

// Along each side of a texel, so that there are enough of them to tell areas apart.
int places_along(std::size_t n_texels) {
  constexpr double k_enough = 1 << 14;
  return std::clamp(static_cast<int>(std::ceil(std::sqrt(k_enough / static_cast<double>(n_texels)))), 4, 16);
}

float fraction(float x) { return x - std::floor(x); }

// Opacity at places spread over all texels.
std::vector<float> spread_opacity(const std::vector<float>& opacity, int width, int height) {
  const int n_along = places_along(opacity.size());
  std::vector<float> result;
  result.reserve(opacity.size() * static_cast<std::size_t>(n_along * n_along));
  const auto at = [&](int x, int y) {
    x = std::clamp(x, 0, width - 1);
    y = std::clamp(y, 0, height - 1);
    return opacity[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                   static_cast<std::size_t>(x)];
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      std::array<float, 9> around;
      for (int k = 0; k < 9; ++k) around[static_cast<std::size_t>(k)] = at(x + k % 3 - 1, y + k / 3 - 1);
      // Different in each texel (numbers of Roberts' sequence), as outlines often run along the same lines.
      const float shift_x = fraction(0.7548777f * static_cast<float>(x) + 0.5698403f * static_cast<float>(y)),
                  shift_y = fraction(0.5698403f * static_cast<float>(x) + 0.7548777f * static_cast<float>(y));
      for (int k = 0; k < n_along * n_along; ++k) {
        const float u = (static_cast<float>(k % n_along) + shift_x) / static_cast<float>(n_along) + 0.5f,
                    v = (static_cast<float>(k / n_along) + shift_y) / static_cast<float>(n_along) + 0.5f;
        const std::size_t i = u < 1 ? 0 : 1, j = v < 1 ? 0 : 1;
        const float s = u - static_cast<float>(i), t = v - static_cast<float>(j);
        const float upper = (1 - s) * around[3 * j + i] + s * around[3 * j + i + 1],
                    lower = (1 - s) * around[3 * j + 3 + i] + s * around[3 * j + 4 + i];
        result.push_back((1 - t) * upper + t * lower);
      }
    }
  }
  return result;
}

}  // namespace

double masked_area(const std::vector<float>& opacity, int width, int height) {
  const std::vector<float> places = spread_opacity(opacity, width, height);
  const auto n = std::count_if(places.begin(), places.end(), [](float share) { return share >= 0.5f; });
  return static_cast<double>(n) / static_cast<double>(places.size()) * static_cast<double>(opacity.size());
}

std::vector<float> with_masked_area(const std::vector<float>& opacity, int width, int height, double area) {
  std::vector<float> best = opacity, scaled(opacity.size());
  double least = std::abs(masked_area(opacity, width, height) - area);
  // What is above 1 is cut off before places between texels are blended, so areas have to be tried.
  const auto area_of = [&](double factor) {
    for (std::size_t i = 0; i < opacity.size(); ++i)
      scaled[i] = std::min(1.0f, static_cast<float>(factor) * opacity[i]);
    const double here = masked_area(scaled, width, height);
    if (std::abs(here - area) < least) {
      least = std::abs(here - area);
      best = scaled;
    }
    return here;
  };
  const double enough = 0.001 * area;
  constexpr double k_least = 1.0 / 16, k_most = 256;
  double low = k_least, high = k_most;
  constexpr int k_halvings = 20;
  for (int i = 0; i < k_halvings && least > enough; ++i) {
    const double factor = std::sqrt(low * high);
    (area_of(factor) < area ? low : high) = factor;
  }
  return best;
}

void keep_thin_parts(std::vector<float>& opacity, int width, int height) {
  constexpr double k_share = 0.8;  // of the area; near outlines as much is lost as is won
  double area = 0;
  for (const float share : opacity) area += static_cast<double>(share);
  if (masked_area(opacity, width, height) < k_share * area)
    opacity = with_masked_area(opacity, width, height, area);
}

}  // namespace recede::detail
