#include <recede/geometry/error.h>
#include <recede/render/detail/even_points.h>
#include <recede/render/hemisphere_square.h>
#include <recede/render/normal_distribution.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <numbers>
#include <utility>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;
constexpr int k_most = 1024;

void check(const VisibleNormalsOptions& options) {
  const auto check_range = [](const char* name, int value, int least, int most) {
    if (value < least || value > most)
      throw OptionError(fmt::format("{} of visible normals: {} to {}, not {}", name, least, most, value));
  };
  check_range("bins", options.bins, 1, k_most);
  check_range("views", options.views, 1, k_most);
  check_range("azimuths", options.azimuths, 1, k_most);
  check_range("samples", options.samples, 2, 1 << 30);
}

/// The counts of one view, those of the first and of the second half of its samples.
using Counts = std::vector<std::uint32_t>;
struct HalfCounts {
  Counts halves[2];
  std::size_t missed = 0;
};

/// Rays for one view. Halves have points of their own, so that they tell each other's noise.
class ViewSampler {
 public:
  ViewSampler(const DisplacedPlane& plane, const VisibleNormalsOptions& options, int view, int azimuth,
              double angle)
      : plane_(plane),
        options_(options),
        halves_{even_points(view, azimuth, 0), even_points(view, azimuth, 1)},
        azimuth_(2 * k_pi * azimuth / options.azimuths),
        level_(std::sin(angle)),
        height_(std::cos(angle)) {}

  HalfCounts count() const {
    HalfCounts all;
    const std::size_t bins =
        static_cast<std::size_t>(options_.bins) * static_cast<std::size_t>(options_.bins);
    for (Counts& half : all.halves) half.resize(bins);
    constexpr int k_block = 4096;
    std::mutex mutex;
    tbb::parallel_for(0, (options_.samples + k_block - 1) / k_block, [&](int block) {
      HalfCounts counted;
      for (Counts& half : counted.halves) half.resize(bins);
      const int end = std::min((block + 1) * k_block, options_.samples);
      for (int sample = block * k_block; sample < end; ++sample) count_one(sample, counted);
      const std::lock_guard lock(mutex);  // whole numbers: their sums don't depend on the order
      for (int half = 0; half < 2; ++half) {
        for (std::size_t i = 0; i < bins; ++i) all.halves[half][i] += counted.halves[half][i];
      }
      all.missed += counted.missed;
    });
    return all;
  }

 private:
  detail::EvenPoints even_points(int view, int azimuth, int half) const {
    const int seed = 2 * (view * options_.azimuths + azimuth) + half;
    return {static_cast<std::uint32_t>(seed), options_.azimuths == 1};
  }
  void count_one(int sample, HalfCounts& counts) const {
    const int half = sample % 2;
    const Vec3 point = halves_[half].point(static_cast<std::uint64_t>(sample / 2));
    const Vec2 place = point.head<2>().cwiseProduct(plane_.sides());
    const double azimuth = options_.azimuths > 1 ? azimuth_ : 2 * k_pi * point.z();
    const double c = std::cos(azimuth), s = std::sin(azimuth);
    const Vec3 toward_viewer(level_ * c, level_ * s, height_);
    // A little above the peaks, so that rounding lets none start below the surface.
    const Vec3 on_peaks(place.x(), place.y(), plane_.heights().max);
    const Vec3 start = on_peaks + 1e-6 * plane_.sides().minCoeff() * toward_viewer;
    const auto hit = plane_.first_hit(start, -toward_viewer);
    if (!hit) {
      ++counts.missed;
      return;
    }
    const std::optional<Vec3> normal = options_.normal_at ? options_.normal_at(hit->uv) : hit->normal;
    if (!normal) return;
    const Vec3& n = *normal;
    const Vec2 in_square = hemisphere_to_square({c * n.x() + s * n.y(), c * n.y() - s * n.x(), n.z()});
    const auto bin = [&](double coordinate) {
      return static_cast<std::size_t>(
          std::clamp(static_cast<int>(coordinate * options_.bins), 0, options_.bins - 1));
    };
    ++counts.halves[half][bin(in_square.x()) * static_cast<std::size_t>(options_.bins) + bin(in_square.y())];
  }

  const DisplacedPlane& plane_;
  const VisibleNormalsOptions& options_;
  detail::EvenPoints halves_[2];
  double azimuth_, level_, height_;
};

/// Shares that sum to 1; nothing when there are no counts.
std::vector<double> normalized(std::vector<double> values) {
  double sum = 0;
  for (const double value : values) sum += value;
  if (!(sum > 0)) return {};
  for (double& value : values) value /= sum;
  return values;
}

std::vector<double> smoothed(const std::vector<double>& shares, int bins) {
  std::vector<double> result(shares.size(), 0.0);
  const auto at = [&](int a, int b) {
    return static_cast<std::size_t>(std::clamp(a, 0, bins - 1)) * static_cast<std::size_t>(bins) +
           static_cast<std::size_t>(std::clamp(b, 0, bins - 1));
  };
  for (int a = 0; a < bins; ++a) {
    for (int b = 0; b < bins; ++b) {
      for (int neighbour = 0; neighbour < 9; ++neighbour)
        result[at(a, b)] += shares[at(a + neighbour / 3 - 1, b + neighbour % 3 - 1)];
    }
  }
  return normalized(std::move(result));
}

/// Views without shares get those of the view before or, at the beginning, after them.
void fill_empty(std::vector<std::vector<double>>& slices, std::size_t azimuths) {
  const auto copy_to = [&](std::size_t slice, std::size_t from) {
    if (slices[slice].empty()) slices[slice] = slices[from];
  };
  for (std::size_t slice = azimuths; slice < slices.size(); ++slice) copy_to(slice, slice - azimuths);
  for (std::size_t slice = slices.size() - azimuths; slice-- > 0;) copy_to(slice, slice + azimuths);
  for (const auto& slice : slices) {
    if (slice.empty()) throw InputError("visible normals: no ray meets the surface");
  }
}

}  // namespace

double VisibleNormals::view_angle(int view) const { return view == 0 ? 0 : (view - 0.5) * k_pi / 2 / views; }

Vec3 VisibleNormals::normal_of_bin(std::size_t bin) const {
  const auto side = static_cast<std::size_t>(bins);
  return square_to_hemisphere(
      {(static_cast<double>(bin / side) + 0.5) / bins, (static_cast<double>(bin % side) + 0.5) / bins});
}

ViewMix mix_for_view(int views, int azimuths, double view_angle, double view_azimuth) {
  // View 0 at 0, view 1 half a step from it, and so on by whole steps.
  const double step = k_pi / 2 / views;
  const double steps = view_angle > 0 ? std::min(view_angle / step, views - 0.5) : 0.0;
  const int view = steps < 0.5 ? 0 : std::min(static_cast<int>(steps + 0.5), views);
  const double ahead = view == 0 ? 2 * steps : steps + 0.5 - view;
  ViewMix mix;
  if (azimuths == 1) {
    const auto slice = static_cast<std::size_t>(view);
    if (ahead <= 0 || ahead >= 1) return {1, {slice + (ahead > 0 ? 1 : 0)}, {1}};
    return {2, {slice, slice + 1}, {1 - ahead, ahead}};
  }
  double turns = view_azimuth / (2 * k_pi);
  turns = std::isfinite(turns) ? (turns - std::floor(turns)) * azimuths : 0.0;
  const int azimuth = std::min(static_cast<int>(turns), azimuths - 1);
  const double aside = std::min(turns - azimuth, 1.0);
  for (int corner = 0; corner < 4; ++corner) {
    const int right = corner % 2, farther = corner / 2;
    const double weight = (right ? aside : 1 - aside) * (farther ? ahead : 1 - ahead);
    if (!(weight > 0)) continue;
    const auto place = static_cast<std::size_t>(mix.count++);
    mix.slices[place] = static_cast<std::size_t>(view + farther) * static_cast<std::size_t>(azimuths) +
                        static_cast<std::size_t>((azimuth + right) % azimuths);
    mix.weights[place] = weight;
  }
  return mix;
}

std::vector<double> normals_for_view(const VisibleNormals& normals, double view_angle, double view_azimuth) {
  const ViewMix mix = mix_for_view(normals.views, normals.azimuths, view_angle, view_azimuth);
  std::vector<double> shares(normals.bin_count(), 0.0);
  for (std::size_t k = 0; k < static_cast<std::size_t>(mix.count); ++k) {
    const std::span<const double> slice = normals.slice(mix.slices[k]);
    for (std::size_t i = 0; i < shares.size(); ++i) shares[i] += mix.weights[k] * slice[i];
  }
  return shares;
}

double total_variation(std::span<const double> a, std::span<const double> b) {
  if (a.size() != b.size()) throw InputError("total variation: the distributions have different bins");
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum / 2;
}

VisibleNormals sample_visible_normals(const DisplacedPlane& plane, const VisibleNormalsOptions& options,
                                      Progress* progress) {
  check(options);
  VisibleNormals normals{.bins = options.bins, .views = options.views, .azimuths = options.azimuths};
  std::vector<std::vector<double>> slices;
  for (int view = 0; view <= options.views; ++view) {
    for (int azimuth = 0; azimuth < options.azimuths; ++azimuth) {
      report_progress(progress, "visible normals",
                      static_cast<double>(slices.size()) / static_cast<double>(normals.slice_count()));
      const HalfCounts counts = ViewSampler(plane, options, view, azimuth, normals.view_angle(view)).count();
      const auto shares_of = [](const Counts& half) {
        return normalized(std::vector<double>(half.begin(), half.end()));
      };
      const std::vector<double> first = shares_of(counts.halves[0]), second = shares_of(counts.halves[1]);
      std::vector<double> sums(counts.halves[0].begin(), counts.halves[0].end());
      for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += counts.halves[1][i];
      normals.noise.push_back(first.size() == second.size() ? total_variation(first, second) / 2 : 1.0);
      normals.missed += counts.missed;
      slices.push_back(normalized(std::move(sums)));
      if (options.smooth && !slices.back().empty()) slices.back() = smoothed(slices.back(), options.bins);
    }
  }
  fill_empty(slices, static_cast<std::size_t>(options.azimuths));
  for (const auto& slice : slices) normals.shares.insert(normals.shares.end(), slice.begin(), slice.end());
  report_progress(progress, "visible normals", 1);
  return normals;
}

void validate(const VisibleNormals& normals) {
  if (normals.bins < 1 || normals.views < 1 || normals.azimuths < 1 ||
      normals.shares.size() != normals.slice_count() * normals.bin_count())
    throw InputError("visible normals: there must be one share for each bin of each view");
  constexpr double k_sum_tolerance = 1e-9;
  for (std::size_t slice = 0; slice < normals.slice_count(); ++slice) {
    double sum = 0;
    for (const double share : normals.slice(slice)) {
      if (!(share >= 0))
        throw InputError(fmt::format("visible normals: a share of slice {} is {}", slice, share));
      sum += share;
    }
    if (!(std::abs(sum - 1) <= k_sum_tolerance))
      throw InputError(fmt::format("visible normals: the shares of slice {} sum to {}, not 1", slice, sum));
  }
}

}  // namespace recede
