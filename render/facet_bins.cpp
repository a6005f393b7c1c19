#include <recede/render/detail/facet_bins.h>

#include <algorithm>
#include <cmath>

namespace recede::detail {
namespace {

constexpr std::size_t k_few = 256;  ///< facets that aren't binned
constexpr int k_side = 48;          ///< of the grid of bins

/// Steps of hard and of soft assignment. Errors of reflectance hardly fall beyond.
constexpr int k_hard_steps = 6, k_soft_steps = 8;

/// The least standard deviation on the disk of a group that shares bins with others: a quarter of a degree.
constexpr double k_least_deviation = 3e-3;

void drop_empty(std::vector<FacetBin>& sums) {
  std::erase_if(sums, [](const FacetBin& sum) { return !(sum.share > 0); });
}

std::size_t nearest(const std::vector<Vec2>& places, const Vec2& place) {
  std::size_t best = 0;
  double least = (places[0] - place).squaredNorm();
  for (std::size_t k = 1; k < places.size(); ++k) {
    const double distance = (places[k] - place).squaredNorm();
    if (distance >= least) continue;
    best = k;
    least = distance;
  }
  return best;
}

/// Finds groups of bins, as sums over them.
class Grouping {
 public:
  explicit Grouping(const std::vector<FacetBin>& bins) : bins_(bins) {
    for (const FacetBin& bin : bins) {
      places_.push_back(bin.place());
      variances_.push_back(bin.variance());
    }
  }

  /// Halves what is widest for its share, again and again.
  std::vector<FacetBin> split() const {
    std::vector<std::size_t> all(bins_.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
    std::vector<Part> parts{make_part(std::move(all))};
    while (parts.size() < FacetDistribution::k_most_groups) {
      const auto widest = std::max_element(parts.begin(), parts.end(),
                                           [](const Part& a, const Part& b) { return a.cost < b.cost; });
      std::vector<std::size_t> halves[2];
      for (const std::size_t i : widest->bins)
        halves[(places_[i] - widest->sum.place()).dot(widest->axis) < 0].push_back(i);
      if (halves[0].empty() || halves[1].empty()) break;  // all in one place
      *widest = make_part(std::move(halves[0]));
      parts.push_back(make_part(std::move(halves[1])));
    }
    std::vector<FacetBin> sums;
    for (const Part& part : parts) sums.push_back(part.sum);
    return sums;
  }

  /// Each bin to the group whose mean is nearest.
  std::vector<FacetBin> assign_to_nearest(const std::vector<FacetBin>& sums) const {
    std::vector<Vec2> middles;
    for (const FacetBin& sum : sums) middles.push_back(sum.place());
    std::vector<FacetBin> result(sums.size());
    for (std::size_t i = 0; i < bins_.size(); ++i) result[nearest(middles, places_[i])].add(bins_[i]);
    drop_empty(result);
    return result;
  }

  /// Each bin in parts to all groups, by their densities there.
  std::vector<FacetBin> assign_in_parts(const std::vector<FacetBin>& sums) const {
    std::vector<Vec2> middles;
    std::vector<double> by_variances, heights;
    for (const FacetBin& sum : sums) {
      middles.push_back(sum.place());
      by_variances.push_back(1 / std::max(sum.variance(), k_least_deviation * k_least_deviation));
      heights.push_back(sum.share * by_variances.back());
    }
    std::vector<FacetBin> result(sums.size());
    std::vector<double> densities(sums.size());
    for (std::size_t i = 0; i < bins_.size(); ++i) {
      double total = 0;
      for (std::size_t k = 0; k < sums.size(); ++k) {
        const double squares = (middles[k] - places_[i]).squaredNorm() + 2 * variances_[i];
        const double exponent = squares * by_variances[k] / 2;
        // Beyond, it is a part of less than a millionth of most that are near.
        densities[k] = exponent < 20 ? heights[k] * std::exp(-exponent) : 0.0;
        total += densities[k];
      }
      if (!(total > 0)) {
        result[nearest(middles, places_[i])].add(bins_[i]);
        continue;
      }
      for (std::size_t k = 0; k < sums.size(); ++k) {
        if (densities[k] > 0) result[k].add(bins_[i], densities[k] / total);
      }
    }
    drop_empty(result);
    return result;
  }

 private:
  /// Some of the bins while they are split.
  struct Part {
    std::vector<std::size_t> bins;
    FacetBin sum{};
    Vec2 axis = Vec2::UnitX();  ///< along which it is widest
    double cost = 0;            ///< its share times the variance along the axis
  };
  Part make_part(std::vector<std::size_t> indices) const {
    Part part{.bins = std::move(indices)};
    for (const std::size_t i : part.bins) part.sum.add(bins_[i]);
    const Vec2 middle = part.sum.place();
    double xx = 0, xy = 0, yy = 0;
    for (const std::size_t i : part.bins) {
      const Vec2 from_middle = places_[i] - middle;
      xx += bins_[i].share * from_middle.x() * from_middle.x();
      xy += bins_[i].share * from_middle.x() * from_middle.y();
      yy += bins_[i].share * from_middle.y() * from_middle.y();
    }
    const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
    part.axis = {std::cos(angle), std::sin(angle)};
    part.cost = (xx + yy) / 2 + std::hypot((xx - yy) / 2, xy);
    return part;
  }

  const std::vector<FacetBin>& bins_;
  std::vector<Vec2> places_;
  std::vector<double> variances_;
};

}  // namespace

Vec2 place_of_slope(const Vec2& slope) {
  // n = (-s, 1) / l, and 1 + n_z = (l + 1) / l. The length by hypot: squares of steep slopes may overflow.
  const double length = std::hypot(slope.x(), slope.y(), 1.0);
  return -slope / length / std::sqrt(1 + 1 / length);
}

Vec2 slope_of_place(const Vec2& place) {
  // Normals on the horizon have no slope; a thousandth of a degree above it is steep enough.
  const double squares = std::min(place.squaredNorm(), 1 - 1e-5), z = 1 - squares;
  return -place * std::sqrt(1 + z) / z;
}

void FacetBin::add(const FacetGroup& group) {
  const Vec2 on_disk = place_of_slope(group.slope);
  // What a spread of slopes is on the disk, about: an angle of cos^2, over the square root of 2.
  const double steepness = 1 + group.slope.squaredNorm();
  const double deviation = group.spread / steepness;
  share += group.share;
  slopes += group.share * group.slope;
  places += group.share * on_disk;
  slope_squares += group.share * (group.slope.squaredNorm() + 2 * group.spread * group.spread);
  place_squares += group.share * (on_disk.squaredNorm() + deviation * deviation);
}

void FacetBin::add(const FacetBin& other, double part) {
  share += part * other.share;
  slopes += part * other.slopes;
  places += part * other.places;
  slope_squares += part * other.slope_squares;
  place_squares += part * other.place_squares;
}

double FacetBin::variance() const {
  return std::max(0.0, (place_squares / share - place().squaredNorm()) / 2);
}

FacetGroup FacetBin::group() const {
  const Vec2 slope = slopes / share;
  const double variance = (slope_squares / share - slope.squaredNorm()) / 2;
  // Less than rounding makes of equal slopes.
  const double least = 1e-14 * (1 + slope.squaredNorm());
  return {share, slope, variance > least ? std::sqrt(variance) : 0.0};
}

FacetBins::FacetBins(const Vec2& least, const Vec2& largest, std::size_t facets)
    : least_(least), is_grid_(facets > k_few) {
  const auto scale = [&](double width) { return width > 0 ? k_side / width : 0.0; };
  scale_ = {scale(largest.x() - least.x()), scale(largest.y() - least.y())};
  if (is_grid_) {
    bins_.resize(static_cast<std::size_t>(k_side) * k_side);
  } else {
    bins_.reserve(facets);
    slopes_.reserve(facets);
  }
}

void FacetBins::add(const FacetGroup& group) {
  if (!is_grid_) {
    // While each slope may get a group, equal ones are counted together.
    const bool are_few = slopes_.size() <= FacetDistribution::k_most_groups;
    const auto known = are_few ? std::find(slopes_.begin(), slopes_.end(), group.slope) : slopes_.end();
    if (known == slopes_.end()) {
      slopes_.push_back(group.slope);
      bins_.emplace_back().add(group);
    } else {
      bins_[static_cast<std::size_t>(known - slopes_.begin())].add(group);
    }
    return;
  }
  const Vec2 place = (place_of_slope(group.slope) - least_).cwiseProduct(scale_);
  const auto along = [](double coordinate) {
    return static_cast<std::size_t>(std::clamp(static_cast<int>(coordinate), 0, k_side - 1));
  };
  bins_[along(place.y()) * k_side + along(place.x())].add(group);
}

std::vector<FacetBin> FacetBins::filled() const {
  std::vector<FacetBin> bins = bins_;
  drop_empty(bins);
  return bins;
}

FacetDistribution group_bins(const std::vector<FacetBin>& bins) {
  std::vector<FacetBin> sums = bins;
  if (bins.size() > FacetDistribution::k_most_groups) {
    const Grouping grouping(bins);
    sums = grouping.split();
    for (int step = 0; step < k_hard_steps; ++step) sums = grouping.assign_to_nearest(sums);
    for (int step = 0; step < k_soft_steps; ++step) sums = grouping.assign_in_parts(sums);
  }
  double total = 0;
  for (const FacetBin& sum : sums) total += sum.share;
  FacetDistribution facets;
  for (const FacetBin& sum : sums) {
    facets.stored[facets.count] = sum.group();
    facets.stored[facets.count++].share /= total;
  }
  return facets;
}

}  // namespace recede::detail
