#include <recede/geometry/error.h>
#include <recede/render/detail/angle_knots.h>
#include <recede/render/scattering_table.h>

#include <cmath>
#include <numbers>

namespace recede {

namespace {

constexpr double k_pi = std::numbers::pi;

}  // namespace

ScatteringTable::Series ScatteringTable::series(double view_angle, double light_angle, double light_azimuth,
                                                double view_azimuth) const {
  Series sums{};
  if (!(light_angle <= k_pi / 2)) return sums;
  const detail::KnotPlace angle = detail::place_of_angle(light_angle, light_angles);
  const detail::KnotPlace azimuth = detail::place_of_azimuth(light_azimuth, light_azimuths);
  const ViewMix mix = mix_for_view(views, azimuths, view_angle, view_azimuth);
  const auto columns = static_cast<std::size_t>(light_azimuths), depth = static_cast<std::size_t>(orders);
  for (std::size_t k = 0; k < static_cast<std::size_t>(mix.count); ++k) {
    const double* slice = values.data() + mix.slices[k] * slice_size();
    const auto add = [&](std::size_t row, std::size_t column, double weight) {
      const double* knot = slice + (row * columns + column) * depth;
      for (std::size_t order = 0; order < depth; ++order) sums[order] += weight * knot[order];
    };
    const double lower = mix.weights[k] * angle.fraction, upper = mix.weights[k] - lower;
    add(angle.before, azimuth.before, upper * (1 - azimuth.fraction));
    add(angle.before, azimuth.after, upper * azimuth.fraction);
    add(angle.after, azimuth.before, lower * (1 - azimuth.fraction));
    add(angle.after, azimuth.after, lower * azimuth.fraction);
  }
  return sums;
}

ScatteringTable::Series ScatteringTable::series(const Vec3& toward_viewer, const Vec3& toward_light) const {
  if (toward_light.z() < 0) return {};
  const double view_azimuth = detail::azimuth_of(toward_viewer);
  // atan2 may give a little more than a right angle for the horizon itself.
  const double light_angle = std::min(detail::polar_angle_of(toward_light), k_pi / 2);
  return series(detail::polar_angle_of(toward_viewer), light_angle,
                detail::azimuth_of(toward_light) - view_azimuth, view_azimuth);
}

double ScatteringTable::sum(const Series& series, double albedo) const {
  double sum = 0, power = albedo, last = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(orders); ++k, power *= albedo)
    sum += last = power * series[k];
  const double again = albedo * hits_again;
  return again < 1 ? sum + last * again / (1 - again) : sum;
}

Rgb ScatteringTable::value(const Rgb& albedo, const Vec3& toward_viewer, const Vec3& toward_light) const {
  const Series terms = series(toward_viewer, toward_light);
  const auto channel = [&](Eigen::Index k) {
    return static_cast<float>(sum(terms, static_cast<double>(albedo[k])));
  };
  return {channel(0), channel(1), channel(2)};
}

ReflectanceTable reflectance_of(const ScatteringTable& table, double albedo) {
  if (!(albedo >= 0 && albedo <= 1)) throw OptionError("an albedo is a number from 0 to 1");
  if (table.values.empty() || table.values.size() != table.slice_count() * table.slice_size())
    throw InputError("a scattering table must have one value for each pair of directions and order");
  ReflectanceTable result{.views = table.views,
                          .azimuths = table.azimuths,
                          .light_angles = table.light_angles,
                          .light_azimuths = table.light_azimuths};
  const auto depth = static_cast<std::size_t>(table.orders);
  for (std::size_t knot = 0; knot < table.values.size(); knot += depth) {
    ScatteringTable::Series terms{};
    for (std::size_t k = 0; k < depth; ++k) terms[k] = table.values[knot + k];
    // Of albedo 0 nothing is left but the first order.
    result.values.push_back(albedo > 0 ? table.sum(terms, albedo) / albedo : terms[0]);
  }
  return result;
}

}  // namespace recede
