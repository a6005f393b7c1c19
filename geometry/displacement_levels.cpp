#include <recede/geometry/detail/level_fit.h>
#include <recede/geometry/displacement_levels.h>
#include <recede/geometry/error.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede {
namespace {

using detail::LevelFit;
using detail::LevelSamples;

/// What a texel of `coarse` texels covers of `fine`, which are not more than twice as many.
struct Cover {
  int first = 0, count = 0;
  double weights[3] = {};  // their sum is 1
};

std::vector<Cover> covers(int fine, int coarse) {
  std::vector<Cover> result(static_cast<std::size_t>(coarse));
  for (int k = 0; k < coarse; ++k) {
    Cover& cover = result[static_cast<std::size_t>(k)];
    // From k fine / coarse to (k + 1) fine / coarse; in whole numbers of 1 / coarse texels.
    const long long from = static_cast<long long>(k) * fine, to = from + fine;
    cover.first = static_cast<int>(from / coarse);
    for (long long texel = cover.first; texel * coarse < to; ++texel) {
      const long long shared = std::min(to, (texel + 1) * coarse) - std::max(from, texel * coarse);
      cover.weights[cover.count++] = static_cast<double>(shared) / fine;
    }
  }
  return result;
}

/// The next level's means; `sample(x, y)` reads this one.
template <typename Sample>
LevelSamples coarser_means(int fine_columns, int fine_rows, Sample&& sample) {
  LevelSamples level{(fine_columns + 1) / 2, (fine_rows + 1) / 2, {}};
  const auto columns = static_cast<std::size_t>(level.columns);
  level.samples.resize(columns * static_cast<std::size_t>(level.rows));
  const std::vector<Cover> across = covers(fine_columns, level.columns), down = covers(fine_rows, level.rows);
  tbb::parallel_for(0, level.rows, [&](int y) {
    const Cover& rows = down[static_cast<std::size_t>(y)];
    double* to = level.samples.data() + static_cast<std::size_t>(y) * columns;
    for (const Cover& texels : across) {
      double sum = 0;
      for (int j = 0; j < rows.count; ++j) {
        double in_row = 0;
        for (int i = 0; i < texels.count; ++i) {
          in_row += texels.weights[i] * sample(texels.first + i, rows.first + j);
        }
        sum += rows.weights[j] * in_row;
      }
      *to++ = sum;
    }
  });
  return level;
}

/// The level with the bits of the map.
DisplacementMap as_map(const DisplacementMap& map, const LevelSamples& level) {
  if (map.bits() == 0) {
    std::vector<float> heights;
    heights.reserve(level.samples.size());
    constexpr double k_most = std::numeric_limits<float>::max();
    for (const double sample : level.samples) {
      heights.push_back(static_cast<float>(std::clamp(sample, -k_most, k_most)));
    }
    return {level.columns, level.rows, std::move(heights), map.border()};
  }
  Raster raster{level.columns, level.rows, 1, map.bits(), false, {}};
  raster.samples.reserve(level.samples.size());
  const double most = (1 << map.bits()) - 1;
  for (const double sample : level.samples) {
    raster.samples.push_back(static_cast<std::uint16_t>(std::clamp(std::round(sample), 0.0, most)));
  }
  return {std::move(raster), map.scale(), map.offset(), map.border()};
}

/// Between the map's surface and that of a level as it is stored.
LevelDifference difference_of(const DisplacementMap& map, const DisplacementMap& level, LevelFit& fit) {
  std::vector<double> samples;
  for (int y = 0; y < level.rows(); ++y) {
    for (int x = 0; x < level.columns(); ++x) samples.push_back(level.sample(x, y));
  }
  const LevelFit::Volume volume = fit.volume(samples);
  const double texels = static_cast<double>(map.columns()) * map.rows();
  const double unit = std::abs(map.height_of(1) - map.height_of(0));
  return {unit * volume.sum / texels, unit * volume.max};
}

}  // namespace

DisplacementLevels::DisplacementLevels(const DisplacementMap& map, const LevelOptions& options,
                                       Progress* progress)
    : map_(&map), differences_(1) {
  if (options.steps < 1) throw OptionError("displacement levels: steps must be at least 1");
  LevelSamples means;
  for (int columns = map.columns(), rows = map.rows(); columns > 1 || rows > 1;) {
    if (coarser_.empty()) {
      means = coarser_means(columns, rows, [&](int x, int y) { return map.sample(x, y); });
    } else {
      means = coarser_means(columns, rows, [&, fine = std::move(means.samples)](int x, int y) {
        return fine[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) +
                    static_cast<std::size_t>(x)];
      });
    }
    columns = means.columns;
    rows = means.rows;
    LevelFit fit(map, columns, rows);
    LevelSamples level = means;
    if (options.rule == LevelRule::least_volume) {
      level.samples = fit.least_volume(std::move(level.samples), options.steps, progress);
    }
    coarser_.push_back(as_map(map, level));
    differences_.push_back(difference_of(map, coarser_.back(), fit));
  }
}

double DisplacementLevels::height_at(const Vec2& uv, double level) const {
  const double place = std::clamp(level, 0.0, count() - 1.0);
  const int fine = static_cast<int>(place);
  const double share = place - fine, height = this->level(fine).height_at(uv);
  return share > 0 ? (1 - share) * height + share * this->level(fine + 1).height_at(uv) : height;
}

FootprintSampling sampling_of(double longer, double shorter) {
  constexpr int k_most_samples = 8;
  const double needed = std::ceil(longer / std::max(shorter, 1.0));
  const int samples = static_cast<int>(std::clamp(needed, 1.0, static_cast<double>(k_most_samples)));
  return {std::log2(std::max({1.0, shorter, longer / samples})), samples};
}

double DisplacementLevels::in_texels(const Vec2& side) const {
  return side.cwiseProduct(Vec2(map_->columns(), map_->rows())).norm();
}

double DisplacementLevels::height_in(const Vec2& middle, const Vec2& side, const Vec2& other_side,
                                     HeightFilter filter) const {
  const double length = in_texels(side), other = in_texels(other_side);
  if (other > length) return sampled(middle, other_side, sampling_of(other, length), filter);
  return sampled(middle, side, sampling_of(length, other), filter);
}

double DisplacementLevels::height_on_edge(const Vec2& middle, const Vec2& side, HeightFilter filter) const {
  const double length = in_texels(side);
  return sampled(middle, side, sampling_of(length, length), filter);
}

double DisplacementLevels::sampled(const Vec2& middle, const Vec2& side, const FootprintSampling& sampling,
                                   HeightFilter filter) const {
  const double place = std::min(sampling.level, count() - 1.0);
  const int fine = static_cast<int>(place);
  const auto combined = [&](int level) {
    double sum = 0, highest = -std::numeric_limits<double>::infinity(), lowest = -highest;
    for (int k = 0; k < sampling.samples; ++k) {
      const Vec2 uv = middle + ((k + 0.5) / sampling.samples - 0.5) * side;
      const double height = this->level(level).height_at(uv);
      sum += height;
      highest = std::max(highest, height);
      lowest = std::min(lowest, height);
    }
    if (filter == HeightFilter::mean) return sum / sampling.samples;
    return filter == HeightFilter::highest ? highest : lowest;
  };
  const double share = place - fine;
  return share > 0 ? (1 - share) * combined(fine) + share * combined(fine + 1) : combined(fine);
}

}  // namespace recede
