#include <recede/render/detail/angle_knots.h>
#include <recede/render/detail/horizon_map.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace recede::detail {
namespace {

constexpr double k_pi = std::numbers::pi;

/// The polar angle at which an azimuth comes to lie in the plane of a facet; a right angle when it rises
/// above it.
double end_of_facet(const Vec3& normal, double azimuth) {
  const double along = normal.x() * std::cos(azimuth) + normal.y() * std::sin(azimuth);
  return along < 0 ? std::atan2(normal.z(), -along) : k_pi / 2;
}

Crest find_crest(const DisplacedPlane& plane, const HeightFieldVisibility& visibility, std::size_t place,
                 double azimuth) {
  constexpr double k_precision = k_pi / 2 / 360;
  const double end = end_of_facet(visibility.normals[place], azimuth);
  double lower = 0, upper = end - k_precision / 2;
  if (is_open(plane, visibility, place, direction_of(upper, azimuth)))
    return {.distance = end < k_pi / 2 ? -1.0F : 0.0F};
  while (upper - lower > k_precision) {
    const double middle = (lower + upper) / 2;
    (is_open(plane, visibility, place, direction_of(middle, azimuth)) ? lower : upper) = middle;
  }
  const double way = distance_to_hit(plane, visibility, place, direction_of(upper, azimuth));
  return {static_cast<float>(1 / std::tan((lower + upper) / 2)), static_cast<float>(way * std::sin(upper))};
}

/// The crests of one place as a point beside it sees them.
struct Neighbour {
  const Crest* crests;
  Vec2 aside;    // from the point to the place
  double above;  // by which the place is higher
  double weight;
  double least_level;  // of the way to a crest that counts

  /// Nothing where the place's own facet ends its view, or where the point has come to the crest or is past
  /// it: there its own facet tells more.
  std::optional<double> slope(std::size_t azimuth, const Vec2& direction) const {
    const Crest& crest = crests[azimuth];
    if (crest.distance < 0) return {};
    if (crest.distance == 0) return 0.0;
    const double level = static_cast<double>(crest.distance) + aside.dot(direction);
    if (!(level > least_level)) return {};
    const double rise = above + static_cast<double>(crest.slope) * static_cast<double>(crest.distance);
    return std::max(rise / level, 0.0);
  }
};

/// Up to four slopes with weights, by size.
class WeightedSlopes {
 public:
  void add(double slope, double weight) {
    std::size_t at = count_++;
    for (; at > 0 && slopes_[at - 1] > slope; --at) {
      slopes_[at] = slopes_[at - 1];
      weights_[at] = weights_[at - 1];
    }
    slopes_[at] = slope;
    weights_[at] = weight;
    all_ += weight;
  }

  /// The slope at which half of the weight is reached; 0 without any.
  double median() const {
    double sum = 0;
    for (std::size_t k = 0; k < count_; ++k) {
      sum += weights_[k];
      if (sum >= all_ / 2) return slopes_[k];
    }
    return 0;
  }

 private:
  std::size_t count_ = 0;
  double all_ = 0;
  std::array<double, 4> slopes_{}, weights_{};
};

}  // namespace

HorizonMap find_horizons(const DisplacedPlane& plane, const HeightFieldVisibility& visibility, int azimuths,
                         Progress* progress) {
  HorizonMap map;
  for (int k = 0; k < azimuths; ++k)
    map.directions.push_back(direction_of(k_pi / 2, 2 * k_pi * k / azimuths).head<2>());
  const auto count = static_cast<std::size_t>(azimuths);
  map.crests.resize(visibility.place_count() * count);
  for (std::size_t azimuth = 0; azimuth < count; ++azimuth) {
    report_progress(progress, "horizons", static_cast<double>(azimuth) / azimuths);
    const double turned = 2 * k_pi * static_cast<double>(azimuth) / azimuths;
    tbb::parallel_for(std::size_t{0}, visibility.place_count(), [&](std::size_t place) {
      map.crests[place * count + azimuth] = find_crest(plane, visibility, place, turned);
    });
  }
  report_progress(progress, "horizons", 1);
  return map;
}

void horizons_at(const HorizonMap& map, const HeightFieldVisibility& visibility, const Vec2& uv,
                 double height, double* slopes) {
  constexpr double k_cells = 0.75;  // with 0, every twentieth lit point at crests is taken for dark
  const Vec2 cell(visibility.sides.x() / visibility.columns, visibility.sides.y() / visibility.rows);
  const PlaceMix mix = mix_of_places(visibility.columns, visibility.rows, uv);
  std::array<Neighbour, 4> neighbours;
  for (std::size_t k = 0; k < 4; ++k) {
    Vec2 aside = visibility.uv(mix.places[k]) - uv;
    aside -= Vec2(std::round(aside.x()), std::round(aside.y()));  // in the nearest copy
    neighbours[k] = {map.of_place(mix.places[k]), aside.cwiseProduct(visibility.sides),
                     visibility.heights[mix.places[k]] - height, mix.weights[k], k_cells * cell.minCoeff()};
  }
  for (std::size_t azimuth = 0; azimuth < map.directions.size(); ++azimuth) {
    WeightedSlopes seen;
    for (const Neighbour& neighbour : neighbours) {
      if (const auto slope = neighbour.slope(azimuth, map.directions[azimuth]))
        seen.add(*slope, neighbour.weight);
    }
    slopes[azimuth] = seen.median();
  }
}

}  // namespace recede::detail
