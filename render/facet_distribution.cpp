#include <recede/geometry/error.h>
#include <recede/render/detail/facet_bins.h>
#include <recede/render/facet_distribution.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace recede {
namespace {

using detail::FacetBins;

void check(const FacetOptions& options) {
  for (const double side : {options.sides.x(), options.sides.y()}) {
    if (!(std::isfinite(side) && side > 0))
      throw OptionError(fmt::format("sides of facets: finite and greater than 0, not {}", side));
  }
  if (options.samples < 1 || options.samples > 64)
    throw OptionError(fmt::format("samples of facets: 1 to 64, not {}", options.samples));
}

struct TexelRectangle {
  int x0, y0, x1, y1;  ///< the last ones excluded
};

/// Steeper ones are taken as so steep, so that squares stay finite: a ten-thousandth of a degree from
/// upright.
constexpr double k_steepest = 1e6;

/// Calls `use(slope)` for places spread evenly over texels.
template <class Use>
void for_slopes(const DisplacementMap& map, const FacetOptions& options, const TexelRectangle& texels,
                const Use& use) {
  const double across = 1.0 / (static_cast<double>(options.samples) * map.columns());
  const double down = 1.0 / (static_cast<double>(options.samples) * map.rows());
  for (int y = options.samples * texels.y0; y < options.samples * texels.y1; ++y) {
    for (int x = options.samples * texels.x0; x < options.samples * texels.x1; ++x) {
      const Vec2 uv((x + 0.5) * across, 1 - (y + 0.5) * down);
      const Vec2 slope = map.derivative_at(uv).cwiseQuotient(options.sides);
      use(Vec2(slope.cwiseMax(-k_steepest).cwiseMin(k_steepest)));
    }
  }
}

FacetDistribution facets_in(const DisplacementMap& map, const FacetOptions& options,
                            const TexelRectangle& texels) {
  constexpr double k_most = std::numeric_limits<double>::infinity();
  Vec2 least(k_most, k_most), largest(-k_most, -k_most);
  std::size_t count = 0;
  for_slopes(map, options, texels, [&](const Vec2& slope) {
    const Vec2 place = detail::place_of_slope(slope);
    least = least.cwiseMin(place);
    largest = largest.cwiseMax(place);
    ++count;
  });
  FacetBins bins(least, largest, count);
  for_slopes(map, options, texels, [&](const Vec2& slope) { bins.add({.share = 1, .slope = slope}); });
  return detail::group_bins(bins.filled());
}

/// A float of which the upper half is kept: not nearer to 0 than the number.
std::uint16_t upper_half(double value) {
  const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
  return static_cast<std::uint16_t>((bits + 0xffff) >> 16);
}
double from_upper_half(std::uint16_t half) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(half) << 16);
}

constexpr int k_steps = 127, k_parts = 255;

/// Whole parts of 255 that sum to 255, as near to the shares as they can be.
std::array<int, FacetDistribution::k_most_groups> whole_shares(std::span<const FacetGroup> groups) {
  std::array<int, FacetDistribution::k_most_groups> parts{};
  int missing = k_parts;
  for (std::size_t k = 0; k < groups.size(); ++k) {
    parts[k] = static_cast<int>(k_parts * groups[k].share);
    missing -= parts[k];
  }
  const auto lacks = [&](std::size_t k) { return k_parts * groups[k].share - parts[k]; };
  for (; missing > 0; --missing) {
    std::size_t most = 0;
    for (std::size_t k = 1; k < groups.size(); ++k) {
      if (lacks(k) > lacks(most)) most = k;
    }
    ++parts[most];
  }
  return parts;
}

/// Spreads are stored as angles, about.
double angle_of_spread(const FacetGroup& group) { return group.spread / (1 + group.slope.squaredNorm()); }

}  // namespace

Vec2 FacetDistribution::mean_slope() const {
  Vec2 mean = Vec2::Zero();
  for (const FacetGroup& group : groups()) mean += group.share * group.slope;
  return mean;
}

FacetDistribution merge_facets(std::span<const FacetGroup> groups) {
  double total = 0;
  for (const FacetGroup& group : groups) {
    const bool is_steep = !(group.slope.cwiseAbs().maxCoeff() <= k_steepest && group.spread <= k_steepest);
    if (!std::isfinite(group.share) || is_steep || group.share < 0 || group.spread < 0)
      throw InputError(
          "facets: a group's slope isn't finite or above 1e6, or its share or spread is below 0");
    total += group.share;
  }
  if (!(total > 0) || !std::isfinite(total)) throw InputError("facets: there must be some with a share");
  std::vector<FacetGroup> sorted(groups.begin(), groups.end());
  std::erase_if(sorted, [](const FacetGroup& group) { return !(group.share > 0); });
  std::stable_sort(sorted.begin(), sorted.end(), [](const FacetGroup& a, const FacetGroup& b) {
    return std::pair(a.slope.x(), a.slope.y()) < std::pair(b.slope.x(), b.slope.y());
  });
  std::vector<detail::FacetBin> bins;
  for (std::size_t k = 0; k < sorted.size(); ++k) {
    if (k == 0 || sorted[k].slope != sorted[k - 1].slope) bins.emplace_back();
    bins.back().add(sorted[k]);
  }
  return detail::group_bins(bins);
}

PackedFacets::PackedFacets(const FacetDistribution& facets) {
  const std::span<const FacetGroup> groups = facets.groups();
  Vec2 least = Vec2::Ones(), largest = -Vec2::Ones();
  double widest = 0;
  for (const FacetGroup& group : groups) {
    const Vec2 place = detail::place_of_slope(group.slope);
    least = least.cwiseMin(place);
    largest = largest.cwiseMax(place);
    widest = std::max(widest, angle_of_spread(group));
  }
  const Vec2 exact_middle = (least + largest) / 2;
  frame_ = {upper_half(exact_middle.x()), upper_half(exact_middle.y()), 0, upper_half(widest)};
  const Vec2 middle(from_upper_half(frame_[0]), from_upper_half(frame_[1]));
  frame_[2] = upper_half((largest - middle).cwiseMax(middle - least).maxCoeff());
  const double step = from_upper_half(frame_[2]) / k_steps,
               spread_step = from_upper_half(frame_[3]) / k_parts;
  const auto shares = whole_shares(groups);
  for (std::size_t k = 0; k < groups.size(); ++k) {
    const Vec2 place = detail::place_of_slope(groups[k].slope) - middle;
    const auto steps = [&](double coordinate) {
      return static_cast<std::int8_t>(step > 0 ? std::lround(coordinate / step) : 0);
    };
    const double spread = angle_of_spread(groups[k]);
    groups_[k] = {static_cast<std::uint8_t>(shares[k]), steps(place.x()), steps(place.y()),
                  static_cast<std::uint8_t>(spread_step > 0 ? std::lround(spread / spread_step) : 0)};
  }
}

FacetDistribution PackedFacets::unpacked() const {
  const Vec2 middle(from_upper_half(frame_[0]), from_upper_half(frame_[1]));
  const double step = from_upper_half(frame_[2]) / k_steps,
               spread_step = from_upper_half(frame_[3]) / k_parts;
  FacetDistribution facets;
  for (const Group& group : groups_) {
    if (group.share == 0) continue;
    const Vec2 slope = detail::slope_of_place(middle + step * Vec2(group.x, group.y));
    facets.stored[facets.count++] = {static_cast<double>(group.share) / k_parts, slope,
                                     group.spread * spread_step * (1 + slope.squaredNorm())};
  }
  return facets;
}

FacetDistribution facets_of(const DisplacementMap& map, const FacetOptions& options) {
  check(options);
  return facets_in(map, options, {0, 0, map.columns(), map.rows()});
}

FacetLevels::FacetLevels(const DisplacementMap& map, const FacetOptions& options, Progress* progress) {
  check(options);
  std::size_t total = 0;
  for (int columns = map.columns(), rows = map.rows();; columns = (columns + 1) / 2, rows = (rows + 1) / 2) {
    levels_.push_back({columns, rows, total});
    total += static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
    if (columns == 1 && rows == 1) break;
  }
  texels_.resize(total);
  for (int number = 0; number < count(); ++number) {
    const Level& level = levels_[static_cast<std::size_t>(number)];
    for (int y = 0; y < level.rows; ++y) {
      report_progress(progress, "facets", (number + static_cast<double>(y) / level.rows) / count());
      tbb::parallel_for(0, level.columns, [&](int x) {
        const std::size_t at = level.first +
                               static_cast<std::size_t>(y) * static_cast<std::size_t>(level.columns) +
                               static_cast<std::size_t>(x);
        const auto end = [&](int texel, int most) {
          return static_cast<int>(std::min<std::int64_t>((std::int64_t{texel} + 1) << number, most));
        };
        texels_[at] = PackedFacets(
            facets_in(map, options, {x << number, y << number, end(x, map.columns()), end(y, map.rows())}));
      });
    }
  }
  report_progress(progress, "facets", 1);
}

}  // namespace recede
