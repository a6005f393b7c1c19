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

/// A part of the bins while they are split.
struct Part {
  std::vector<std::size_t> bins;
  FacetBin sum;
  Vec2 axis = Vec2::UnitX();  ///< along which it is widest
  double cost = 0;            ///< its share times the variance along the axis
};

Part make_part(const std::vector<FacetBin>& bins, std::vector<std::size_t> indices) {
  Part part{.bins = std::move(indices), .sum = {}};
  for (const std::size_t i : part.bins) part.sum.add(bins[i]);
  const Vec2 middle = part.sum.place();
  double xx = 0, xy = 0, yy = 0;
  for (const std::size_t i : part.bins) {
    const Vec2 from_middle = bins[i].place() - middle;
    xx += bins[i].share * from_middle.x() * from_middle.x();
    xy += bins[i].share * from_middle.x() * from_middle.y();
    yy += bins[i].share * from_middle.y() * from_middle.y();
  }
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
  part.axis = {std::cos(angle), std::sin(angle)};
  part.cost = (xx + yy) / 2 + std::hypot((xx - yy) / 2, xy);
  return part;
}

/// Halves the part that is widest for its share, again and again.
std::vector<FacetBin> split(const std::vector<FacetBin>& bins) {
  std::vector<std::size_t> all(bins.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  std::vector<Part> parts{make_part(bins, std::move(all))};
  while (parts.size() < FacetDistribution::k_most_groups) {
    const auto widest = std::max_element(parts.begin(), parts.end(),
                                         [](const Part& a, const Part& b) { return a.cost < b.cost; });
    std::vector<std::size_t> halves[2];
    for (const std::size_t i : widest->bins)
      halves[(bins[i].place() - widest->sum.place()).dot(widest->axis) < 0].push_back(i);
    if (halves[0].empty() || halves[1].empty()) break;  // all in one place
    *widest = make_part(bins, std::move(halves[0]));
    parts.push_back(make_part(bins, std::move(halves[1])));
  }
  std::vector<FacetBin> sums;
  for (const Part& part : parts) sums.push_back(part.sum);
  return sums;
}

void drop_empty(std::vector<FacetBin>& sums) {
  std::erase_if(sums, [](const FacetBin& sum) { return !(sum.share > 0); });
}

std::size_t nearest(const std::vector<Vec2>& places, const Vec2& place) {
  std::size_t best = 0;
  for (std::size_t k = 1; k < places.size(); ++k) {
    if ((places[k] - place).squaredNorm() < (places[best] - place).squaredNorm()) best = k;
  }
  return best;
}

std::vector<FacetBin> assign_to_nearest(const std::vector<FacetBin>& bins,
                                        const std::vector<FacetBin>& sums) {
  std::vector<Vec2> places;
  for (const FacetBin& sum : sums) places.push_back(sum.place());
  std::vector<FacetBin> result(sums.size());
  for (const FacetBin& bin : bins) result[nearest(places, bin.place())].add(bin);
  drop_empty(result);
  return result;
}

/// Each bin in parts to all groups, by their densities there.
std::vector<FacetBin> assign_in_parts(const std::vector<FacetBin>& bins, const std::vector<FacetBin>& sums) {
  std::vector<Vec2> places;
  std::vector<double> variances;
  for (const FacetBin& sum : sums) {
    places.push_back(sum.place());
    variances.push_back(std::max(sum.variance(), k_least_deviation * k_least_deviation));
  }
  std::vector<FacetBin> result(sums.size());
  std::vector<double> densities(sums.size());
  for (const FacetBin& bin : bins) {
    const Vec2 place = bin.place();
    const double inside = 2 * bin.variance();
    double total = 0;
    for (std::size_t k = 0; k < sums.size(); ++k) {
      const double distance = ((places[k] - place).squaredNorm() + inside) / (2 * variances[k]);
      densities[k] = distance < 50 ? sums[k].share / variances[k] * std::exp(-distance) : 0.0;
      total += densities[k];
    }
    if (!(total > 0)) {
      result[nearest(places, place)].add(bin);
      continue;
    }
    for (std::size_t k = 0; k < sums.size(); ++k) {
      if (densities[k] > 0) result[k].add(bin, densities[k] / total);
    }
  }
  drop_empty(result);
  return result;
}

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
  }
}

void FacetBins::add(const FacetGroup& group) {
  if (!is_grid_) {
    bins_.emplace_back().add(group);
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
  std::vector<FacetBin> sums = split(bins);
  if (bins.size() > sums.size()) {
    for (int step = 0; step < k_hard_steps; ++step) sums = assign_to_nearest(bins, sums);
    for (int step = 0; step < k_soft_steps; ++step) sums = assign_in_parts(bins, sums);
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
