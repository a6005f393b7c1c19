#include <recede/lod/detail/footprint_heights.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede::detail {
namespace {

/// Share of the front where a direction turns from the back to the front of the surface.
double share_of_front(double facing) {
  constexpr double k_turning = 0.1;  // cosine up to which both sides count
  const double t = std::clamp(0.5 + 0.5 * facing / k_turning, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

}  // namespace

FootprintHeights::FootprintHeights(const DisplacementLevels& levels, FootprintRule rule)
    : levels_(levels), rule_(rule), texels_(levels.level(0).columns(), levels.level(0).rows()) {}

/// Places in a footprint, and the level to read.
struct FootprintHeights::Samples {
  Vec2 first, step, other_step;
  int n, n_other;
  double level;
};

double FootprintHeights::filtered(const Samples& samples, double front) const {
  const double place = std::min(samples.level, levels_.count() - 1.0);
  const int fine = static_cast<int>(place);
  const auto combined = [&](int number) {
    const DisplacementMap& map = levels_.level(number);
    double highest = -std::numeric_limits<double>::infinity(), lowest = -highest;
    for (int i = 0; i < samples.n; ++i) {
      for (int j = 0; j < samples.n_other; ++j) {
        const double height = map.height_at(samples.first + i * samples.step + j * samples.other_step);
        highest = std::max(highest, height);
        lowest = std::min(lowest, height);
      }
    }
    return front * highest + (1 - front) * lowest;
  };
  const double share = place - fine;
  return share > 0 ? (1 - share) * combined(fine) + share * combined(fine + 1) : combined(fine);
}

double FootprintHeights::by_side(const Vec2& uv, const Vec2& side, const Vec2& other_side,
                                 double facing) const {
  const double length = side.cwiseProduct(texels_).norm(), other = other_side.cwiseProduct(texels_).norm();
  if (other > length) return by_side(uv, other_side, side, facing);
  const auto needed = [](double texels, int most) {
    return static_cast<int>(std::clamp(std::ceil(texels), 1.0, static_cast<double>(most)));
  };
  Samples samples;
  samples.n_other = needed(other, k_across);
  const double across = std::max(other / samples.n_other, 1.0);
  samples.n = needed(length / across, k_along);
  samples.level = std::log2(std::max(across, length / samples.n));
  samples.step = side / samples.n;
  samples.other_step = other_side / samples.n_other;
  samples.first =
      uv - 0.5 * (samples.n - 1) * samples.step - 0.5 * (samples.n_other - 1) * samples.other_step;
  return filtered(samples, share_of_front(facing));
}

double FootprintHeights::inside(const Vec2& uv, const Vec2& side, const Vec2& other_side,
                                double facing) const {
  if (rule_ == FootprintRule::none) return levels_.level(0).height_at(uv);
  if (rule_ == FootprintRule::mean) return levels_.height_in(uv, side, other_side, HeightFilter::mean);
  return by_side(uv, side, other_side, facing);
}

double FootprintHeights::on_edge(const Vec2& uv, const Vec2& step, double facing) const {
  if (rule_ == FootprintRule::none) return levels_.level(0).height_at(uv);
  if (rule_ == FootprintRule::mean) return levels_.height_on_edge(uv, step, HeightFilter::mean);
  const Vec2 in_texels = step.cwiseProduct(texels_);
  const Vec2 across = Vec2(-in_texels.y(), in_texels.x()).cwiseQuotient(texels_);
  return by_side(uv, step, across, facing);
}

double FootprintHeights::at_corner(const Vec2& uv, double texels, double facing) const {
  if (rule_ == FootprintRule::none) return levels_.level(0).height_at(uv);
  if (rule_ == FootprintRule::mean) return levels_.height_at(uv, sampling_of(texels, texels).level);
  return by_side(uv, {texels / texels_.x(), 0}, {0, texels / texels_.y()}, facing);
}

}  // namespace recede::detail
