#include <recede/geometry/error.h>
#include <recede/render/diffuse_scattering.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace recede {

DiffuseTransport::DiffuseTransport(const HeightFieldVisibility& visibility, const BaseCurvature& curvature) {
  for (std::size_t place = 0; place < visibility.place_count(); ++place) {
    const BentDirections bent = bend_directions(visibility, place, curvature);
    std::vector<double> weights(bent.directions.size());
    for (std::size_t i = 0; i < weights.size(); ++i)
      weights[i] = bent.weights[i] * std::max(0.0, bent.normal.dot(bent.directions[i]));
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    double from_places = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const SeenPlace& seen = visibility.seen_from(place, i);
      if (!(weights[i] > 0) || (!seen.is_place() && !seen.is_nothing())) continue;
      if (seen.is_nothing()) {
        gaps_.push_back({bent.directions[i], weights[i] / sum});
        continue;
      }
      sources_.push_back(
          {static_cast<std::uint32_t>(visibility.place(seen)), static_cast<float>(weights[i] / sum)});
      from_places += static_cast<double>(sources_.back().weight);
    }
    sky_.push_back(std::max(0.0, 1 - from_places));
    first_source_.push_back(sources_.size());
    first_gap_.push_back(gaps_.size());
  }
}

void DiffuseTransport::gather(std::span<const double> from, std::size_t lanes, std::span<double> to) const {
  for (std::size_t place = 0; place < place_count(); ++place) {
    double* sums = to.data() + place * lanes;
    std::fill(sums, sums + lanes, 0.0);
    for (std::size_t i = first_source_[place]; i < first_source_[place + 1]; ++i) {
      const double* source = from.data() + sources_[i].place * lanes;
      const auto weight = static_cast<double>(sources_[i].weight);
      for (std::size_t lane = 0; lane < lanes; ++lane) sums[lane] += weight * source[lane];
    }
  }
}

std::vector<double> DiffuseTransport::sky_light(const std::function<double(const Vec3&)>& radiance) const {
  std::vector<double> light(place_count(), 0.0);
  tbb::parallel_for(std::size_t{0}, place_count(), [&](std::size_t place) {
    for (std::size_t i = first_gap_[place]; i < first_gap_[place + 1]; ++i)
      light[place] += gaps_[i].weight * radiance(gaps_[i].direction);
  });
  return light;
}

double DiffuseTransport::hits_again(int orders) const {
  std::vector<double> light = sky_, next(light.size());
  const auto mean_of = [](const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  };
  double rest = 1 - mean_of(light);
  for (int order = 1; order < orders; ++order) {
    gather(light, 1, next);
    light.swap(next);
    rest -= mean_of(light);
  }
  // A geometric series that begins after the last order: last * h / (1 - h) = rest.
  return rest > 0 ? rest / (rest + mean_of(light)) : 0.0;
}

double ScatteredLight::irradiance(std::size_t place, double albedo, int last) const {
  double sum = 0, power = 1, term = 0;
  for (std::size_t k = 0; k < orders.size(); ++k, power *= albedo) {
    if (last > 0 && static_cast<int>(k) >= last) return sum;
    sum += term = power * orders[k][place];
  }
  if (last > 0) return sum;
  const double again = albedo * hits_again;
  return sum + (again < 1 ? term * again / (1 - again) : 0.0);
}

ScatteredLight scatter_light(const DiffuseTransport& transport, std::vector<double> first, int orders) {
  constexpr int k_most_orders = 64;
  if (orders < 1 || orders > k_most_orders)
    throw OptionError(fmt::format("orders of scattered light: 1 to {}, not {}", k_most_orders, orders));
  if (first.size() != transport.place_count() ||
      !std::all_of(first.begin(), first.end(), [](double value) { return std::isfinite(value); }))
    throw InputError("scattered light: there must be one finite irradiance for each place");
  ScatteredLight light{.hits_again = transport.hits_again(orders)};
  light.orders.push_back(std::move(first));
  while (static_cast<int>(light.orders.size()) < orders) {
    std::vector<double> next(transport.place_count());
    transport.gather(light.orders.back(), 1, next);
    light.orders.push_back(std::move(next));
  }
  return light;
}

std::vector<double> direct_light(const HeightFieldVisibility& visibility, const Vec3& toward_light,
                                 const std::function<double(std::size_t place)>& openness) {
  std::vector<double> light(visibility.place_count(), 0.0);
  tbb::parallel_for(std::size_t{0}, light.size(), [&](std::size_t place) {
    const double facing = visibility.normals[place].dot(toward_light);
    if (facing > 0 && toward_light.z() > 0) light[place] = facing * openness(place);
  });
  return light;
}

}  // namespace recede
