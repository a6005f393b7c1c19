#include <recede/geometry/error.h>
#include <recede/render/detail/angle_knots.h>
#include <recede/render/detail/even_points.h>
#include <recede/render/detail/horizon_map.h>
#include <recede/render/diffuse_scattering.h>
#include <recede/render/scattering_table.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;

void check(const ScatteringTableOptions& options) {
  const auto check_range = [](std::string_view name, int value, int least, int most) {
    if (value < least || value > most)
      throw OptionError(fmt::format("{} of a scattering table: {} to {}, not {}", name, least, most, value));
  };
  check_range("views", options.views, 1, 1024);
  check_range("azimuths", options.azimuths, 1, 1024);
  check_range("samples", options.samples, 2, 1 << 24);
  check_range("light angles", options.light_angles, 2, 1024);
  check_range("light azimuths", options.light_azimuths, 1, 1024);
  check_range("orders", options.orders, 1, ScatteringTable::k_most_orders);
  check_range("places", options.places, 1, 1024);
  if (options.light_azimuths % options.azimuths != 0)
    throw OptionError(
        fmt::format("a scattering table's {} azimuths of the viewer don't divide {} of the light",
                    options.azimuths, options.light_azimuths));
  constexpr double k_most_numbers = 1 << 28;
  const double slices = (options.views + 1.0) * options.azimuths;
  if (slices * options.light_angles * options.light_azimuths * options.orders > k_most_numbers ||
      slices * options.samples > k_most_numbers)
    throw OptionError(
        "a scattering table of so many views, lights, orders and samples doesn't fit in memory");
}

/// As many places as fit for each texel, but an odd number: then they lie in the middles of cells or parts of
/// them, never on the lines between facets.
int places_along(int texels, int most) {
  if (texels >= most) return most;
  const int each = most / texels;
  return texels * (each % 2 == 1 ? each : each - 1);
}

/// A place that a ray of a view came to, and which of the light's azimuths the viewer stood at.
struct SeenFrom {
  std::uint32_t place;
  std::uint32_t turn;
};

/// Numbers by azimuth of the light counted from u, added to those counted from the viewer's azimuth.
void add_turned(const double* by_azimuth, std::size_t turn, std::size_t azimuths, double* to) {
  for (std::size_t k = turn; k < azimuths; ++k) to[k - turn] += by_azimuth[k];
  for (std::size_t k = 0; k < turn; ++k) to[azimuths - turn + k] += by_azimuth[k];
}

class TableMaker {
 public:
  TableMaker(const DisplacedPlane& plane, const ScatteringTableOptions& options, Progress* progress)
      : plane_(plane),
        options_(options),
        azimuths_(static_cast<std::size_t>(options.light_azimuths)),
        visibility_(compute_visibility(plane,
                                       {.directions = options.directions,
                                        .columns = places_along(plane.map().columns(), options.places),
                                        .rows = places_along(plane.map().rows(), options.places)},
                                       progress)),
        transport_(visibility_),
        horizons_(detail::find_horizons(plane, visibility_, options.light_azimuths, progress)) {
    for (std::size_t k = 0; k < azimuths_; ++k) {
      const double azimuth = 2 * k_pi * static_cast<double>(k) / options.light_azimuths;
      cosines_.push_back(std::cos(azimuth));
      sines_.push_back(std::sin(azimuth));
    }
    table_ = {.views = options.views,
              .azimuths = options.azimuths,
              .light_angles = options.light_angles,
              .light_azimuths = options.light_azimuths,
              .orders = options.orders,
              .hits_again = transport_.hits_again(options.orders)};
    table_.values.resize(table_.slice_count() * table_.slice_size(), 0.0);
    seen_.resize(table_.slice_count());
  }

  ScatteringTable make(Progress* progress) {
    const int views = options_.views + 1;
    for (int view = 0; view < views; ++view) {
      report_progress(progress, "direct light", static_cast<double>(view) / views);
      constexpr int k_blocks = 16;  // of samples, so that threads have work with few azimuths
      for (int azimuth = 0; azimuth < options_.azimuths; ++azimuth) look_from(view, azimuth, k_blocks);
    }
    if (options_.orders > 1) {
      for (int row = 0; row < options_.light_angles; row += k_rows_at_once) {
        report_progress(progress, "scattered light", static_cast<double>(row) / options_.light_angles);
        const int end = std::min(row + k_rows_at_once, options_.light_angles);
        tbb::parallel_for(row, end, [&](int k) { scatter(k); });
      }
    }
    report_progress(progress, "scattered light", 1);
    return std::move(table_);
  }

 private:
  static constexpr int k_rows_at_once = 8;

  double angle(int row) const { return row * k_pi / 2 / (options_.light_angles - 1); }
  double view_angle(int view) const { return view == 0 ? 0 : (view - 0.5) * k_pi / 2 / options_.views; }
  double* knot(std::size_t slice, int row) {
    return table_.values.data() + slice * table_.slice_size() +
           static_cast<std::size_t>(row) * azimuths_ * static_cast<std::size_t>(options_.orders);
  }

  /// What one block of a view's rays sees.
  struct Block {
    std::vector<SeenFrom> seen;
    std::vector<double> light;  // by the light's angle and azimuth, counted from the viewer's
  };

  void look_from(int view, int azimuth, int blocks) {
    const std::size_t slice = static_cast<std::size_t>(view * options_.azimuths + azimuth);
    std::vector<Block> found(static_cast<std::size_t>(blocks));
    tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t block) {
      found[block].light.resize(static_cast<std::size_t>(options_.light_angles) * azimuths_, 0.0);
      for (int sample = static_cast<int>(block); sample < options_.samples; sample += blocks)
        look(view, azimuth, sample, found[block]);
    });
    for (const Block& block : found)
      seen_[slice].insert(seen_[slice].end(), block.seen.begin(), block.seen.end());
    if (seen_[slice].empty()) throw InputError("scattering table: no ray meets the surface");
    const auto depth = static_cast<std::size_t>(options_.orders);
    double* first_order = knot(slice, 0);
    for (std::size_t i = 0; i < found[0].light.size(); ++i) {
      double sum = 0;
      for (const Block& block : found) sum += block.light[i];
      first_order[i * depth] = sum / static_cast<double>(seen_[slice].size());
    }
  }

  void look(int view, int azimuth, int sample, Block& block) const {
    const auto seed = static_cast<std::uint32_t>(view * options_.azimuths + azimuth);
    const Vec3 point =
        detail::EvenPoints(seed, options_.azimuths == 1).point(static_cast<std::uint64_t>(sample));
    const auto turn = options_.azimuths == 1 ? static_cast<std::size_t>(point.z() * options_.light_azimuths)
                                             : static_cast<std::size_t>(azimuth) * azimuths_ /
                                                   static_cast<std::size_t>(options_.azimuths);
    const Vec2 place = point.head<2>().cwiseProduct(plane_.sides());
    const Vec3 toward_viewer = detail::direction_of(
        view_angle(view), 2 * k_pi * static_cast<double>(turn) / options_.light_azimuths);
    // A little above the peaks, so that rounding lets none start below the surface.
    const Vec3 start =
        Vec3(place.x(), place.y(), plane_.heights().max) + 1e-6 * plane_.sides().minCoeff() * toward_viewer;
    const auto hit = plane_.first_hit(start, -toward_viewer);
    if (!hit) return;
    block.seen.push_back(
        {static_cast<std::uint32_t>(visibility_.place_near(hit->uv)), static_cast<std::uint32_t>(turn)});
    add_direct_light(*hit, turn, block);
  }

  /// Of a place that is seen, for all lights.
  void add_direct_light(const DisplacedPlane::Hit& hit, std::size_t turn, Block& block) const {
    std::vector<double> horizons(azimuths_);
    detail::horizons_at(horizons_, visibility_, hit.uv, plane_.map().height_at(hit.uv), horizons.data());
    std::rotate(horizons.begin(), horizons.begin() + static_cast<std::ptrdiff_t>(turn), horizons.end());
    std::vector<double> along(azimuths_);
    for (std::size_t k = 0; k < azimuths_; ++k) {
      const std::size_t azimuth = (k + turn) % azimuths_;
      along[k] = hit.normal.x() * cosines_[azimuth] + hit.normal.y() * sines_[azimuth];
    }
    for (int row = 0; row < options_.light_angles; ++row) {
      const double c = std::cos(angle(row)) * hit.normal.z(), s = std::sin(angle(row));
      const double slope = std::cos(angle(row)) / std::sin(angle(row));
      double* light = block.light.data() + static_cast<std::size_t>(row) * azimuths_;
      for (std::size_t k = 0; k < azimuths_; ++k) {
        const double facing = std::max(0.0, c + s * along[k]);
        light[k] += slope >= horizons[k] ? facing : 0.0;
      }
    }
  }

  /// Direct light on all places for one angle of the light: by place, azimuth. The step at horizons is as
  /// wide as a row, since one place stands for what lies around it.
  std::vector<double> direct_light_on_places(int row) const {
    std::vector<double> light;
    light.reserve(visibility_.place_count() * azimuths_);
    const double step = k_pi / 2 / (options_.light_angles - 1);
    for (std::size_t place = 0; place < visibility_.place_count(); ++place) {
      const detail::Crest* crests = horizons_.of_place(place);
      const Vec3& n = visibility_.normals[place];
      const double c = std::cos(angle(row)) * n.z(), s = std::sin(angle(row));
      for (std::size_t k = 0; k < azimuths_; ++k) {
        const double facing = std::max(0.0, c + s * (n.x() * cosines_[k] + n.y() * sines_[k]));
        const double horizon = std::atan2(1, static_cast<double>(crests[k].slope));
        const double above = crests[k].distance > 0 ? (horizon - angle(row)) / step + 0.5 : 1.0;
        light.push_back(facing * std::clamp(above, 0.0, 1.0));
      }
    }
    return light;
  }

  /// All orders from the second on, for one angle of the light: one pass over the places for each.
  void scatter(int row) {
    std::vector<double> light = direct_light_on_places(row), next(light.size());
    std::vector<double> sums(azimuths_);
    const auto depth = static_cast<std::size_t>(options_.orders);
    for (std::size_t order = 1; order < depth; ++order) {
      transport_.gather(light, azimuths_, next);
      light.swap(next);
      for (std::size_t slice = 0; slice < seen_.size(); ++slice) {
        std::fill(sums.begin(), sums.end(), 0.0);
        for (const SeenFrom& seen : seen_[slice])
          add_turned(light.data() + seen.place * azimuths_, seen.turn, azimuths_, sums.data());
        double* to = knot(slice, row);
        for (std::size_t k = 0; k < azimuths_; ++k)
          to[k * depth + order] = sums[k] / static_cast<double>(seen_[slice].size());
      }
    }
  }

  const DisplacedPlane& plane_;
  const ScatteringTableOptions& options_;
  std::size_t azimuths_;
  HeightFieldVisibility visibility_;
  DiffuseTransport transport_;
  detail::HorizonMap horizons_;
  std::vector<double> cosines_, sines_;
  ScatteringTable table_;
  std::vector<std::vector<SeenFrom>> seen_;  // by slice
};

}  // namespace

ScatteringTable make_scattering_table(const DisplacedPlane& plane, const ScatteringTableOptions& options,
                                      Progress* progress) {
  check(options);
  return TableMaker(plane, options, progress).make(progress);
}

}  // namespace recede
