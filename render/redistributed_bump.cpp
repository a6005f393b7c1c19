#include <recede/render/detail/quick_square.h>
#include <recede/render/detail/view_grids.h>
#include <recede/render/hemisphere_square.h>
#include <recede/render/redistributed_bump.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <utility>

namespace recede {
namespace {

/// Keeps places inside of the bin in which they were found, in spite of rounding.
constexpr double k_inside = 1 - 1e-12;

/// Searches end by comparing with the sums of so many bins at once: a line of the cache.
constexpr int k_at_once = 8;

/// How far the normals of a bump map are from the middle of the disk of equal areas, at most.
double reach_of_bumps(const VisibleNormals& normals) {
  // On the square, the larger distance along its axes is the radius on the disk.
  const std::span<const double> shares = normals.slice(0);
  const auto bins = static_cast<std::size_t>(normals.bins);
  double reach = 0;
  for (std::size_t bin = 0; bin < shares.size(); ++bin) {
    if (!(shares[bin] > 0)) continue;
    for (const std::size_t line : {bin / bins, bin / bins + 1, bin % bins, bin % bins + 1})
      reach = std::max(reach, std::abs(2 * static_cast<double>(line) / normals.bins - 1));
  }
  return reach;
}

}  // namespace

/// Distributions, and how much each of them counts; see `ViewMix`.
template <std::size_t k_slices>
struct RedistributedBump::Mix {
  std::array<std::size_t, k_slices> slices{};
  std::array<double, k_slices> weights{};

  Mix() = default;
  explicit Mix(const ViewMix& mix) {
    std::copy_n(mix.slices.begin(), k_slices, slices.begin());
    std::copy_n(mix.weights.begin(), k_slices, weights.begin());
  }
};

/// Cumulated shares of a mixture of distributions. Sums are mixed, not quotients of them, so that they are
/// the sums of the mixed distribution.
template <std::size_t k_slices>
class RedistributedBump::Cumulated {
 public:
  /// Along a row; `bins` for the sums over rows.
  Cumulated(const RedistributedBump& bump, const Mix<k_slices>& mix, int row)
      : bins_(bump.bins_), weights_(mix.weights) {
    const std::size_t rows = static_cast<std::size_t>(bins_) + 1;
    for (std::size_t k = 0; k < k_slices; ++k)
      sums_[k] = bump.sums_.data() + (mix.slices[k] * rows + static_cast<std::size_t>(row)) * bump.stride_;
  }

  double before(int bin) const {
    double sum = weights_[0] * sums_[0][bin];
    for (std::size_t k = 1; k < k_slices; ++k) sum += weights_[k] * sums_[k][bin];
    return sum;
  }
  double total() const { return before(bins_); }

  /// Up to a place from 0 to 1 inside of a bin.
  double up_to(int bin, double fraction) const {
    const double begin = before(bin);
    return begin + fraction * (before(bin + 1) - begin);
  }

  /// The bin in which the sum reaches a value, and how far inside of it. Never one without a share.
  std::pair<int, double> find(double value) const {
    // The last bin that begins at or below the value, without jumps: by halves down to eight bins, and these
    // all at once.
    int bin = 0;
    for (int step = static_cast<int>(std::bit_floor(static_cast<unsigned>(bins_))); step >= k_at_once;
         step /= 2) {
      const int next = std::min(bin + step, bins_ - 1);
      bin = before(next) <= value ? next : bin;
    }
    bin = std::max(0, std::min(bin, bins_ - (k_at_once - 1)));
    int passed = 0;
    for (int next = 1; next < k_at_once; ++next) passed += before(bin + next) <= value ? 1 : 0;
    bin = std::min(bin + passed, bins_ - 1);
    while (bin > 0 && !(before(bin + 1) > before(bin))) --bin;  // rounding led beyond the last share
    const double begin = before(bin), share = before(bin + 1) - begin;
    return {bin, share > 0 ? std::clamp((value - begin) / share, 0.0, k_inside) : 0.5};
  }

 private:
  int bins_;
  std::array<const double*, k_slices> sums_{};
  std::array<double, k_slices> weights_{};
};

RedistributedBump::RedistributedBump(const VisibleNormals& normals, const RedistributionOptions& options)
    : bins_(normals.bins), views_(normals.views), azimuths_(normals.azimuths), options_(options) {
  validate(normals);
  const auto bins = static_cast<std::size_t>(bins_);
  constexpr auto k_line = static_cast<std::size_t>(k_at_once);
  stride_ = (bins + 1 + k_line - 1) / k_line * k_line;
  // Lines are filled up with what no search passes.
  constexpr double k_beyond = 2;
  sums_.assign(normals.slice_count() * (bins + 1) * stride_, k_beyond);
  for (std::size_t slice = 0; slice < normals.slice_count(); ++slice) {
    const std::span<const double> shares = normals.slice(slice);
    double* row_sums = sums_.data() + slice * (bins + 1) * stride_;
    double* over_rows = row_sums + bins * stride_;
    over_rows[0] = 0;
    for (std::size_t row = 0; row < bins; ++row, row_sums += stride_) {
      row_sums[0] = 0;
      for (std::size_t column = 0; column < bins; ++column)
        row_sums[column + 1] = row_sums[column] + shares[row * bins + column];
      over_rows[row + 1] = over_rows[row] + row_sums[bins];
    }
  }
  if (azimuths_ == 1 && options_.conditional && !options_.literal && !options_.exact) {
    grids_ = std::make_shared<const detail::ViewGrids>(detail::sample_view_grids(
        reach_of_bumps(normals),
        [&](const Vec3& normal, double view_angle) { return redistribute(normal, view_angle); }));
  }
}

template <std::size_t k_from, std::size_t k_to>
Vec2 RedistributedBump::moved(const Vec2& place, const Mix<k_from>& from, const Mix<k_to>& to) const {
  const auto bin_of = [&](double coordinate) {
    return std::clamp(static_cast<int>(coordinate * bins_), 0, bins_ - 1);
  };
  const int row = bin_of(place.x()), column = bin_of(place.y());
  const double first = Cumulated(*this, from, bins_).up_to(row, place.x() * bins_ - row);
  const Cumulated along_row(*this, from, row);
  const double row_share = along_row.total();
  double second = place.y();  // a row without normals: evenly
  if (row_share > 0) second = along_row.up_to(column, place.y() * bins_ - column) / row_share;

  const auto [new_row, down] = Cumulated(*this, to, bins_).find(first);
  const Cumulated along_new_row(*this, to, new_row);
  const double scale = options_.conditional ? along_new_row.total() : row_share;
  const auto [new_column, across] = along_new_row.find(second * scale);
  return {(new_row + down) / bins_, (new_column + across) / bins_};
}

Vec2 RedistributedBump::moved(const Vec2& place, const ViewMix& from, const ViewMix& to) const {
  return moved(place, Mix<4>(from), Mix<4>(to));
}

Vec3 RedistributedBump::redistribute(const Vec3& normal, double view_angle, double view_azimuth) const {
  ViewMix from = mix(0, view_azimuth), to = mix(view_angle, view_azimuth);
  if (options_.literal) std::swap(from, to);
  return square_to_hemisphere(moved(hemisphere_to_square(normal), from, to));
}

Vec3 RedistributedBump::restore(const Vec3& normal, double view_angle, double view_azimuth) const {
  ViewMix from = mix(view_angle, view_azimuth), to = mix(0, view_azimuth);
  if (options_.literal) std::swap(from, to);
  return square_to_hemisphere(moved(hemisphere_to_square(normal), from, to));
}

// Without azimuths a view lies between two distributions, and that from above is one.
RedistributedBump::Mix<2> RedistributedBump::mix_between_angles(double right_angles) const {
  const double steps = std::min(right_angles * views_, views_ - 0.5);
  const bool is_first = steps < 0.5;  // a step of half the length
  const int view = is_first ? 0 : static_cast<int>(steps + 0.5);
  const double ahead = is_first ? 2 * steps : steps + 0.5 - view;
  Mix<2> mix;
  mix.slices = {static_cast<std::size_t>(view), static_cast<std::size_t>(std::min(view + 1, views_))};
  mix.weights = {1 - ahead, ahead};
  return mix;
}

// Back to the bump map and on to the view is one move: in between, both have the same cumulated shares.
// Heights times a share are slopes times it.
Vec2 RedistributedBump::moved_for_view(const Vec2& place, double level, double height,
                                       double displaced) const {
  const Mix<2> seen = mix_between_angles(detail::quick_angle(height, level));
  if (displaced > 0)
    return moved(place, mix_between_angles(detail::quick_angle(height, displaced * level)), seen);
  Mix<1> flat;
  flat.weights = {1};
  return moved(place, flat, seen);
}

Vec2 RedistributedBump::moved_between_slices(Vec2 place, double view_angle, double azimuth,
                                             double displaced) const {
  const ViewMix flat = mix(0, azimuth), seen = mix(view_angle, azimuth);
  const ViewMix now = displaced > 0 ? mix(equivalent_view_angle(view_angle, displaced), azimuth) : flat;
  if (options_.literal) {
    if (displaced > 0) place = moved(place, flat, now);
    return moved(place, seen, flat);
  }
  if (displaced > 0) place = moved(place, now, flat);
  return moved(place, flat, seen);
}

Vec3 RedistributedBump::normal_for_view(const Vec3& bump_normal, const Vec3& toward_viewer,
                                        double displaced) const {
  if (displaced <= 0 && grids_) return detail::look_up(*grids_, bump_normal, toward_viewer);
  const double level =
      std::sqrt(toward_viewer.x() * toward_viewer.x() + toward_viewer.y() * toward_viewer.y());
  const double height = std::max(toward_viewer.z(), 0.0);
  const double c = level > 0 ? toward_viewer.x() / level : 1, s = level > 0 ? toward_viewer.y() / level : 0;
  const Vec3& n = bump_normal;
  Vec2 place = detail::quick_hemisphere_to_square({c * n.x() + s * n.y(), c * n.y() - s * n.x(), n.z()});
  if (azimuths_ == 1 && !options_.literal && options_.conditional) {
    place = moved_for_view(place, level, height, displaced);
  } else {
    const double azimuth = azimuths_ > 1 ? std::atan2(s, c) : 0;
    place = moved_between_slices(place, std::atan2(level, height), azimuth, displaced);
  }
  const Vec3 moved_normal = detail::quick_square_to_hemisphere(place);
  return {c * moved_normal.x() - s * moved_normal.y(), s * moved_normal.x() + c * moved_normal.y(),
          moved_normal.z()};
}

double equivalent_view_angle(double view_angle, double displaced) {
  const double least = std::min(view_angle, std::numbers::pi / 2);
  return std::atan2(displaced * std::sin(least), std::cos(least));
}

}  // namespace recede
