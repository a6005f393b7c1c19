#include <recede/geometry/error.h>
#include <recede/render/detail/angle_knots.h>
#include <recede/render/reflectance_table.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace recede {
namespace {

using detail::azimuth_of;
using detail::direction_of;
using detail::place_of_angle;
using detail::place_of_azimuth;
using detail::polar_angle_of;

constexpr double k_pi = std::numbers::pi;

void check(const ReflectanceTableOptions& options) {
  constexpr int k_most = 1024;
  if (options.light_angles < 2 || options.light_angles > k_most)
    throw OptionError(
        fmt::format("light angles of a reflectance table: 2 to {}, not {}", k_most, options.light_angles));
  if (options.light_azimuths < 1 || options.light_azimuths > k_most)
    throw OptionError(fmt::format("light azimuths of a reflectance table: 1 to {}, not {}", k_most,
                                  options.light_azimuths));
  if (options.lobe != FacetLobe::diffuse && !(options.exponent > 0 && std::isfinite(options.exponent)))
    throw OptionError("the exponent of a lobe is a number greater than 0");
}

double scattered_by(const Vec3& normal, const Vec3& light, const Vec3& viewer,
                    const ReflectanceTableOptions& options) {
  const double facing = normal.dot(light);
  if (!(facing > 0)) return 0;
  if (options.lobe == FacetLobe::diffuse) return facing;
  const double along = options.lobe == FacetLobe::reflection ? (2 * facing * normal - light).dot(viewer)
                                                             : normal.dot((light + viewer).normalized());
  return along > 0 ? std::pow(along, options.exponent) : 0.0;
}

struct WeightedNormal {
  Vec3 normal;
  double share = 0;
};

std::vector<WeightedNormal> normals_of_slice(const VisibleNormals& normals, std::size_t slice) {
  std::vector<WeightedNormal> result;
  const std::span<const double> shares = normals.slice(slice);
  for (std::size_t bin = 0; bin < shares.size(); ++bin) {
    if (shares[bin] > 0) result.push_back({normals.normal_of_bin(bin), shares[bin]});
  }
  return result;
}

}  // namespace

double ReflectanceTable::value(double view_angle, double light_angle, double light_azimuth,
                               double view_azimuth) const {
  if (!(light_angle <= k_pi / 2)) return 0;
  const detail::KnotPlace angle = place_of_angle(light_angle, light_angles);
  const detail::KnotPlace azimuth = place_of_azimuth(light_azimuth, light_azimuths);
  const ViewMix mix = mix_for_view(views, azimuths, view_angle, view_azimuth);
  const auto columns = static_cast<std::size_t>(light_azimuths);
  double sum = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(mix.count); ++k) {
    const double* slice = values.data() + mix.slices[k] * slice_size();
    const auto along_row = [&](std::size_t row) {
      const double before = slice[row * columns + azimuth.before];
      return before + azimuth.fraction * (slice[row * columns + azimuth.after] - before);
    };
    const double upper = along_row(angle.before);
    sum += mix.weights[k] * (upper + angle.fraction * (along_row(angle.after) - upper));
  }
  return sum;
}

double ReflectanceTable::value(const Vec3& toward_viewer, const Vec3& toward_light) const {
  if (toward_light.z() < 0) return 0;
  const double view_azimuth = azimuth_of(toward_viewer);
  // atan2 may give a little more than a right angle for the horizon itself.
  const double light_angle = std::min(polar_angle_of(toward_light), k_pi / 2);
  return value(polar_angle_of(toward_viewer), light_angle, azimuth_of(toward_light) - view_azimuth,
               view_azimuth);
}

ReflectanceTable make_reflectance_table(const VisibleNormals& normals, const ReflectanceTableOptions& options,
                                        Progress* progress) {
  check(options);
  validate(normals);
  ReflectanceTable table{.views = normals.views,
                         .azimuths = normals.azimuths,
                         .light_angles = options.light_angles,
                         .light_azimuths = options.light_azimuths};
  table.values.resize(normals.slice_count() * table.slice_size());
  const auto azimuths = static_cast<std::size_t>(normals.azimuths);
  for (std::size_t slice = 0; slice < normals.slice_count(); ++slice) {
    report_progress(progress, "reflectance table",
                    static_cast<double>(slice) / static_cast<double>(normals.slice_count()));
    const std::vector<WeightedNormal> seen = normals_of_slice(normals, slice);
    const Vec3 viewer = direction_of(normals.view_angle(static_cast<int>(slice / azimuths)), 0);
    double* values = table.values.data() + slice * table.slice_size();
    tbb::parallel_for(0, options.light_angles, [&](int row) {
      for (int column = 0; column < options.light_azimuths; ++column) {
        Vec3 light = direction_of(row * k_pi / 2 / (options.light_angles - 1),
                                  column * 2 * k_pi / options.light_azimuths);
        if (options.from_below) light.z() = -light.z();
        double sum = 0;
        for (const WeightedNormal& n : seen) sum += n.share * scattered_by(n.normal, light, viewer, options);
        values[row * options.light_azimuths + column] = sum;
      }
    });
  }
  report_progress(progress, "reflectance table", 1);
  return table;
}

namespace {

/// The mean over the viewer's azimuths, for pairs of directions on the knots of the light's angles.
class PairValues {
 public:
  explicit PairValues(const ReflectanceTable& table) : table_(table) {}

  double angle(int row) const { return row * k_pi / 2 / (table_.light_angles - 1); }
  double operator()(int view_row, int light_row, int column) const {
    double sum = 0;
    for (int azimuth = 0; azimuth < table_.azimuths; ++azimuth) {
      sum += table_.value(angle(view_row), angle(light_row), column * 2 * k_pi / table_.light_azimuths,
                          azimuth * 2 * k_pi / table_.azimuths);
    }
    return sum / table_.azimuths;
  }

  /// Integrates over the hemisphere what depends on row and column, by the trapezoidal rule.
  template <class Function>
  double integrate(const Function& function) const {
    const double step = k_pi / 2 / (table_.light_angles - 1);
    double sum = 0;
    for (int row = 0; row < table_.light_angles; ++row) {
      const double weight = (row == 0 || row == table_.light_angles - 1 ? 0.5 : 1) * std::sin(angle(row));
      for (int column = 0; column < table_.light_azimuths; ++column) sum += weight * function(row, column);
    }
    return sum * step * 2 * k_pi / table_.light_azimuths;
  }

 private:
  const ReflectanceTable& table_;
};

}  // namespace

ReflectanceViolations measure_violations(const ReflectanceTable& table, double largest_angle) {
  if (!(largest_angle > 0 && largest_angle <= k_pi / 2))
    throw OptionError("violations of a reflectance table: the largest angle is from above 0 to pi / 2");
  const PairValues pairs(table);
  const int columns = table.light_azimuths;
  int rows = 1;
  while (rows < table.light_angles && pairs.angle(rows) <= largest_angle) ++rows;
  ReflectanceViolations found;
  double squares = 0, mean = 0;
  for (int view = 0; view < rows; ++view) {
    for (int light = 0; light < rows; ++light) {
      for (int column = 0; column < columns; ++column) {
        const int opposite = (columns - column) % columns;  // the viewer's azimuth, seen from the light's
        const double there = pairs(view, light, column) * std::cos(pairs.angle(view));
        const double back = pairs(light, view, opposite) * std::cos(pairs.angle(light));
        squares += (there - back) * (there - back);
        mean += (there + back) / 2;
        found.reciprocity_max = std::max(found.reciprocity_max, std::abs(there - back));
      }
    }
  }
  const double count = static_cast<double>(rows) * rows * columns;
  mean /= count;
  if (mean > 0) {
    found.reciprocity_rms = std::sqrt(squares / count) / mean;
    found.reciprocity_max /= mean;
  }
  for (int row = 0; row < rows; ++row) {
    const double gathered = pairs.integrate([&](int light, int column) { return pairs(row, light, column); });
    const double scattered = pairs.integrate(
        [&](int view, int column) { return pairs(view, row, column) * std::cos(pairs.angle(view)); });
    found.most_gathered = std::max(found.most_gathered, gathered / k_pi);
    found.most_scattered =
        std::max(found.most_scattered, scattered / (k_pi * std::max(std::cos(pairs.angle(row)), 1e-300)));
  }
  return found;
}

namespace {

void check_values(const ReflectanceTable& table) {
  const bool sized = table.views >= 1 && table.azimuths >= 1 && table.light_angles >= 2 &&
                     table.light_azimuths >= 1 &&
                     table.values.size() == static_cast<std::size_t>(table.views + 1) *
                                                static_cast<std::size_t>(table.azimuths) * table.slice_size();
  if (!sized) throw InputError("reflectance table: there must be one value for each pair of directions");
  for (const double value : table.values) {
    if (!(value >= 0) || !std::isfinite(value))
      throw InputError(fmt::format("reflectance table: a value is {}", value));
  }
}

}  // namespace

/// A view as a choice among slices: each is drawn in proportion to its weight and to all that it scatters.
struct ReflectanceSampler::View {
  int count = 0;
  std::array<const double*, 4> sums{};
  std::array<double, 4> weights{};
  double total = 0;  ///< of the mixed slices
  double azimuth = 0;
};

ReflectanceSampler::ReflectanceSampler(const ReflectanceTable& table)
    : views_(table.views),
      azimuths_(table.azimuths),
      rows_(table.light_angles - 1),
      columns_(table.light_azimuths) {
  check_values(table);
  for (int row = 0; row < rows_; ++row) heights_.push_back(std::cos(row * k_pi / 2 / rows_));
  heights_.push_back(0);
  const auto columns = static_cast<std::size_t>(columns_);
  const std::size_t slices = table.values.size() / table.slice_size();
  for (std::size_t slice = 0; slice < slices; ++slice) {
    const std::span<const double> values = table.slice(slice);
    double sum = 0;
    sums_.push_back(0);
    for (std::size_t row = 0; row + 1 < heights_.size(); ++row) {
      const double solid_angle = (heights_[row] - heights_[row + 1]) * 2 * k_pi / columns_;
      for (std::size_t column = 0; column < columns; ++column) {
        const std::size_t next = (column + 1) % columns;
        const double corners = values[row * columns + column] + values[row * columns + next] +
                               values[(row + 1) * columns + column] + values[(row + 1) * columns + next];
        sums_.push_back(sum += corners / 4 * solid_angle);
      }
    }
  }
}

ReflectanceSampler::View ReflectanceSampler::view(const Vec3& toward_viewer) const {
  View view;
  view.azimuth = azimuth_of(toward_viewer);
  const ViewMix mix = mix_for_view(views_, azimuths_, polar_angle_of(toward_viewer), view.azimuth);
  const std::size_t cells = static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_);
  view.count = mix.count;
  view.weights = mix.weights;
  for (std::size_t k = 0; k < static_cast<std::size_t>(mix.count); ++k) {
    view.sums[k] = sums_.data() + mix.slices[k] * (cells + 1);
    view.total += view.weights[k] * view.sums[k][cells];
  }
  return view;
}

/// Per solid angle, of the mixture.
double ReflectanceSampler::cell_density(const View& view, std::size_t cell) const {
  if (!(view.total > 0)) return 0;
  double mean = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(view.count); ++k)
    mean += view.weights[k] * (view.sums[k][cell + 1] - view.sums[k][cell]);
  const std::size_t row = cell / static_cast<std::size_t>(columns_);
  return mean / view.total / ((heights_[row] - heights_[row + 1]) * 2 * k_pi / columns_);
}

ReflectanceSampler::Sample ReflectanceSampler::sample(const Vec3& toward_viewer, const Vec2& random) const {
  const View view = this->view(toward_viewer);
  if (!(view.total > 0)) return {};
  const std::size_t cells = static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_);
  // One number draws the cell, and what is left of it the height inside.
  const double wanted = random.x() * view.total;
  const auto up_to = [&](std::size_t cell) {
    double sum = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(view.count); ++k)
      sum += view.weights[k] * view.sums[k][cell];
    return sum;
  };
  std::size_t cell = 0, last = cells - 1;
  while (cell < last) {
    const std::size_t middle = (cell + last) / 2;
    up_to(middle + 1) > wanted ? last = middle : cell = middle + 1;
  }
  while (cell > 0 && !(up_to(cell + 1) > up_to(cell))) --cell;  // rounding led beyond the last
  const double share = up_to(cell + 1) - up_to(cell);
  const double down = share > 0 ? std::clamp((wanted - up_to(cell)) / share, 0.0, 1.0) : 0.5;
  const std::size_t row = cell / static_cast<std::size_t>(columns_);
  const std::size_t column = cell % static_cast<std::size_t>(columns_);
  const double height = heights_[row] + down * (heights_[row + 1] - heights_[row]);
  const double level = std::sqrt(std::max(0.0, 1 - height * height));
  const double azimuth = view.azimuth + (static_cast<double>(column) + random.y()) * 2 * k_pi / columns_;
  return {{level * std::cos(azimuth), level * std::sin(azimuth), height}, cell_density(view, cell)};
}

double ReflectanceSampler::density(const Vec3& toward_viewer, const Vec3& toward_light) const {
  if (toward_light.z() < 0) return 0;
  const View view = this->view(toward_viewer);
  std::size_t row = 0;
  while (row + 2 < heights_.size() && heights_[row + 1] > toward_light.z()) ++row;
  const detail::KnotPlace azimuth = place_of_azimuth(azimuth_of(toward_light) - view.azimuth, columns_);
  return cell_density(view, row * static_cast<std::size_t>(columns_) + azimuth.before);
}

}  // namespace recede
