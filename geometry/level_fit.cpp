#include <recede/geometry/detail/level_fit.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace recede::detail {
namespace {

constexpr int k_lengths = 11;          // from the range of the samples down to 1/1024 of it
constexpr int k_patience = 12;         // steps without a gain after which a length is left
constexpr double k_least_gain = 1e-4;  // of the volume

}  // namespace

std::vector<LevelFit::Place> LevelFit::places(const DisplacementMap& map, int fine, int coarse) {
  const auto inside = [&](int k) {
    if (k >= 0 && k < coarse) return k;
    return (k < 0) == (map.border() == MapBorder::periodic) ? coarse - 1 : 0;
  };
  std::vector<Place> result;
  for (int k = 0; k < fine; ++k) {
    const double at = (k + 0.5) / fine * coarse - 0.5, before = std::floor(at);
    result.push_back({inside(static_cast<int>(before)), inside(static_cast<int>(before) + 1), at - before});
  }
  return result;
}

LevelFit::LevelFit(const DisplacementMap& map, int columns, int rows)
    : map_(map),
      columns_(columns),
      rows_(rows),
      across_(places(map, map.columns(), columns)),
      down_(places(map, map.rows(), rows)),
      shares_(static_cast<std::size_t>(rows)),
      row_volumes_(static_cast<std::size_t>(map.rows())) {
  for (int y = 0; y < map.rows(); ++y) {
    const Place& place = down_[static_cast<std::size_t>(y)];
    shares_[static_cast<std::size_t>(place.before)].push_back({y, 1 - place.fraction});
    shares_[static_cast<std::size_t>(place.after)].push_back({y, place.fraction});
  }
}

void LevelFit::compare_row(int y, const std::vector<double>& samples, std::vector<double>& mixed,
                           bool with_signs) {
  const auto columns = static_cast<std::size_t>(columns_);
  const Place& row = down_[static_cast<std::size_t>(y)];
  const double* before = samples.data() + static_cast<std::size_t>(row.before) * columns;
  const double* after = samples.data() + static_cast<std::size_t>(row.after) * columns;
  for (std::size_t x = 0; x < columns; ++x) {
    mixed[x] = before[x] + (after[x] - before[x]) * row.fraction;
  }
  float* signs = with_signs ? row_signs_.data() + static_cast<std::size_t>(y) * columns : nullptr;
  if (with_signs) std::fill(signs, signs + columns, 0.0F);
  Volume volume;
  for (int x = 0; x < map_.columns(); ++x) {
    const Place& place = across_[static_cast<std::size_t>(x)];
    const auto left = static_cast<std::size_t>(place.before), right = static_cast<std::size_t>(place.after);
    const double difference =
        map_.sample(x, y) - (mixed[left] + (mixed[right] - mixed[left]) * place.fraction);
    volume.sum += std::abs(difference);
    volume.max = std::max(volume.max, std::abs(difference));
    if (!with_signs || difference == 0) continue;
    const auto weight = static_cast<float>(place.fraction);
    const float sign = difference > 0 ? 1.0F : -1.0F;
    signs[left] += sign * (1 - weight);
    signs[right] += sign * weight;
  }
  row_volumes_[static_cast<std::size_t>(y)] = volume;
}

LevelFit::Volume LevelFit::compare(const std::vector<double>& samples, bool with_signs) {
  if (with_signs) {
    row_signs_.resize(static_cast<std::size_t>(map_.rows()) * static_cast<std::size_t>(columns_));
  }
  tbb::parallel_for(tbb::blocked_range<int>(0, map_.rows(), 16), [&](const tbb::blocked_range<int>& range) {
    std::vector<double> mixed(static_cast<std::size_t>(columns_));
    for (int y = range.begin(); y != range.end(); ++y) compare_row(y, samples, mixed, with_signs);
  });
  // Added in the order of the rows, for the same sum with any number of threads.
  Volume total;
  for (const Volume& row : row_volumes_) {
    total.sum += row.sum;
    total.max = std::max(total.max, row.max);
  }
  return total;
}

/// Moves every sample against the volume's derivative, equation 12 of the source; the sums of signs are those
/// of the last comparison.
void LevelFit::step(std::vector<double>& samples, double length) const {
  const auto columns = static_cast<std::size_t>(columns_);
  // Four times the texels of the map that one of the level covers.
  const double area =
      4 * (static_cast<double>(map_.columns()) / columns_) * (static_cast<double>(map_.rows()) / rows_);
  tbb::parallel_for(0, rows_, [&](int y) {
    double* row = samples.data() + static_cast<std::size_t>(y) * columns;
    for (std::size_t x = 0; x < columns; ++x) {
      double sum = 0;
      for (const Share& share : shares_[static_cast<std::size_t>(y)]) {
        sum +=
            share.weight * static_cast<double>(row_signs_[static_cast<std::size_t>(share.row) * columns + x]);
      }
      row[x] += length / area * sum;
    }
  });
}

std::vector<double> LevelFit::least_volume(std::vector<double> samples, int steps, Progress* progress) {
  double least = map_.sample(0, 0), largest = least;
  for (int y = 0; y < map_.rows(); ++y) {
    for (int x = 0; x < map_.columns(); ++x) {
      least = std::min(least, map_.sample(x, y));
      largest = std::max(largest, map_.sample(x, y));
    }
  }
  std::vector<double> best = samples;
  double best_volume = compare(samples, true).sum;
  double length = largest - least;
  for (int k = 0; k < k_lengths; ++k, length /= 2) {
    report_progress(progress, "fit level", static_cast<double>(k) / k_lengths);
    double mark = best_volume;  // when it was last lowered by more than the least gain
    for (int i = 0, since_mark = 0; i < steps && since_mark < k_patience; ++i, ++since_mark) {
      step(samples, length);
      const double volume = compare(samples, true).sum;
      if (volume < best_volume) {
        best_volume = volume;
        best = samples;
      }
      if (best_volume < mark * (1 - k_least_gain)) {
        mark = best_volume;
        since_mark = 0;
      }
    }
    samples = best;
    compare(samples, true);  // its signs
  }
  return best;
}

}  // namespace recede::detail
