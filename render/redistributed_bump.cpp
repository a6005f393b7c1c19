#include <recede/render/hemisphere_square.h>
#include <recede/render/redistributed_bump.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <utility>

namespace recede {
namespace {

/// Keeps places inside of the bin in which they were found, in spite of rounding.
constexpr double k_inside = 1 - 1e-12;

}  // namespace

/// Cumulated shares of a mixture of `k_slices` distributions; those that a mix doesn't have count nothing.
/// Sums are mixed, not quotients of them, so that they are the sums of the mixed distribution.
template <std::size_t k_slices>
class RedistributedBump::Cumulated {
 public:
  Cumulated(const RedistributedBump& bump, const ViewMix& mix, int row) : bins_(bump.bins_) {
    const auto entries = static_cast<std::size_t>(bins_ + 1);
    for (std::size_t k = 0; k < k_slices; ++k) {
      weights_[k] = mix.weights[k];
      sums_[k] = bump.sums_.data() + (mix.slices[k] * entries + static_cast<std::size_t>(row)) * entries;
    }
  }

  double before(int bin) const {
    double sum = 0;
    for (std::size_t k = 0; k < k_slices; ++k) sum += weights_[k] * sums_[k][bin];
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
    // The last bin that begins at or below the value, by halves of a power of two, without jumps.
    int bin = 0;
    for (int step = static_cast<int>(std::bit_floor(static_cast<unsigned>(bins_))); step > 0; step /= 2) {
      const int next = std::min(bin + step, bins_ - 1);
      bin = before(next) <= value ? next : bin;
    }
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
  for (std::size_t slice = 0; slice < normals.slice_count(); ++slice) {
    const std::span<const double> shares = normals.slice(slice);
    std::vector<double> over_rows{0};
    for (std::size_t row = 0; row < bins; ++row) {
      double sum = 0;
      sums_.push_back(0);
      for (std::size_t column = 0; column < bins; ++column)
        sums_.push_back(sum += shares[row * bins + column]);
      over_rows.push_back(over_rows.back() + sum);
    }
    sums_.insert(sums_.end(), over_rows.begin(), over_rows.end());
  }
}

template <std::size_t k_slices>
Vec2 RedistributedBump::moved_among(const Vec2& place, const ViewMix& from, const ViewMix& to) const {
  using Sums = Cumulated<k_slices>;
  const auto bin_of = [&](double coordinate) {
    return std::clamp(static_cast<int>(coordinate * bins_), 0, bins_ - 1);
  };
  const int row = bin_of(place.x()), column = bin_of(place.y());
  const double first = Sums(*this, from, bins_).up_to(row, place.x() * bins_ - row);
  const Sums along_row(*this, from, row);
  const double row_share = along_row.total();
  double second = place.y();  // a row without normals: evenly
  if (row_share > 0) second = along_row.up_to(column, place.y() * bins_ - column) / row_share;

  const auto [new_row, down] = Sums(*this, to, bins_).find(first);
  const Sums along_new_row(*this, to, new_row);
  const double scale = options_.conditional ? along_new_row.total() : row_share;
  const auto [new_column, across] = along_new_row.find(second * scale);
  return {(new_row + down) / bins_, (new_column + across) / bins_};
}

// Without azimuths, a view lies between two distributions at most.
Vec2 RedistributedBump::moved(const Vec2& place, const ViewMix& from, const ViewMix& to) const {
  return azimuths_ == 1 ? moved_among<2>(place, from, to) : moved_among<4>(place, from, to);
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

Vec3 RedistributedBump::normal_for_view(const Vec3& bump_normal, const Vec3& toward_viewer,
                                        double displaced) const {
  const double level = toward_viewer.head<2>().norm();
  const double c = level > 0 ? toward_viewer.x() / level : 1, s = level > 0 ? toward_viewer.y() / level : 0;
  const double view_angle = std::atan2(level, std::max(toward_viewer.z(), 0.0));
  const double azimuth = azimuths_ > 1 ? std::atan2(s, c) : 0;
  const Vec3& n = bump_normal;
  Vec2 place = hemisphere_to_square({c * n.x() + s * n.y(), c * n.y() - s * n.x(), n.z()});
  ViewMix flat = mix(0, azimuth), seen = mix(view_angle, azimuth);
  ViewMix now = displaced > 0 ? mix(equivalent_view_angle(view_angle, displaced), azimuth) : flat;
  if (options_.literal) {
    if (displaced > 0) place = moved(place, flat, now);
    place = moved(place, seen, flat);
  } else {
    if (displaced > 0) place = moved(place, now, flat);
    place = moved(place, flat, seen);
  }
  const Vec3 moved_normal = square_to_hemisphere(place);
  return {c * moved_normal.x() - s * moved_normal.y(), s * moved_normal.x() + c * moved_normal.y(),
          moved_normal.z()};
}

double equivalent_view_angle(double view_angle, double displaced) {
  const double least = std::min(view_angle, std::numbers::pi / 2);
  return std::atan2(displaced * std::sin(least), std::cos(least));
}

}  // namespace recede
