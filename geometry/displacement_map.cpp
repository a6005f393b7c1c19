#include <recede/geometry/displacement_map.h>
#include <recede/geometry/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace recede {
namespace {

void check_size(int columns, int rows, std::size_t n_samples) {
  if (columns < 1 || rows < 1) throw InputError("a displacement map needs at least one texel");
  const std::size_t texels = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  if (n_samples != texels) {
    throw InputError(fmt::format("a displacement map of {} x {} texels needs {} heights, not {}", columns,
                                 rows, texels, n_samples));
  }
}

std::string texel_name(std::size_t at, int columns) {
  const auto width = static_cast<std::size_t>(columns);
  return fmt::format("displacement map: the height of texel ({}, {})", at % width, at / width);
}

/// Between a and b for t from 0 to 1, in spite of rounding.
double between(double a, double b, double t) { return t < 0.5 ? a + (b - a) * t : b - (b - a) * (1 - t); }

}  // namespace

DisplacementMap::DisplacementMap(Raster samples, double scale, double offset, MapBorder border)
    : columns_(samples.width),
      rows_(samples.height),
      bits_(samples.bits),
      border_(border),
      scale_(scale),
      offset_(offset) {
  if (samples.channels != 1 || (bits_ != 8 && bits_ != 16)) {
    throw InputError("a displacement map needs one channel of 8 or 16 bits");
  }
  check_size(columns_, rows_, samples.samples.size());
  if (!std::isfinite(scale) || !std::isfinite(offset) || !std::isfinite(offset + scale)) {
    throw OptionError("displacement map: scale and offset must be finite");
  }
  const auto most = static_cast<std::uint16_t>((1 << bits_) - 1);
  const auto above = std::find_if(samples.samples.begin(), samples.samples.end(),
                                  [&](std::uint16_t sample) { return sample > most; });
  if (above != samples.samples.end()) {
    throw InputError(texel_name(static_cast<std::size_t>(above - samples.samples.begin()), columns_) +
                     " has more bits than the map");
  }
  most_ = most;
  whole_ = std::move(samples.samples);
}

DisplacementMap::DisplacementMap(int columns, int rows, std::vector<float> heights, MapBorder border)
    : columns_(columns), rows_(rows), border_(border) {
  check_size(columns, rows, heights.size());
  const auto bad = std::find_if(heights.begin(), heights.end(), [](float h) { return !std::isfinite(h); });
  if (bad != heights.end()) {
    throw InputError(texel_name(static_cast<std::size_t>(bad - heights.begin()), columns) + " is not finite");
  }
  floats_ = std::move(heights);
}

DisplacementMap::CellPlace DisplacementMap::place(double coordinate, int count) const {
  if (border_ == MapBorder::periodic) coordinate -= std::floor(coordinate);
  // Not a number becomes 0.
  const double at = std::max(0.0, std::min(coordinate, 1.0)) * count - 0.5;
  const double before = std::floor(at);
  return {static_cast<int>(before) + 1, at - before};
}

struct DisplacementMap::Corners {
  double upper_left, upper_right, lower_left, lower_right;  // samples
  CellPlace x, y;
};

DisplacementMap::Corners DisplacementMap::corners_at(const Vec2& uv) const {
  const CellPlace x = column_place(uv.x()), y = row_place(uv.y());
  const int left = column(x.cell - 1), right = column(x.cell), upper = row(y.cell - 1), lower = row(y.cell);
  return {sample(left, upper), sample(right, upper), sample(left, lower), sample(right, lower), x, y};
}

double DisplacementMap::height_at(const Vec2& uv) const {
  const Corners c = corners_at(uv);
  return height_of(between(between(c.upper_left, c.upper_right, c.x.fraction),
                           between(c.lower_left, c.lower_right, c.x.fraction), c.y.fraction));
}

Vec2 DisplacementMap::derivative_at(const Vec2& uv) const {
  const Corners c = corners_at(uv);
  const double right = between(c.upper_right - c.upper_left, c.lower_right - c.lower_left, c.y.fraction);
  const double down = between(c.lower_left - c.upper_left, c.lower_right - c.upper_right, c.x.fraction);
  return {scale_ / most_ * right * columns_, -scale_ / most_ * down * rows_};
}

Vec2 DisplacementMap::smooth_derivative_at(const Vec2& uv) const {
  const CellPlace x = column_place(uv.x()), y = row_place(uv.y());
  // The four columns and rows around the cell, which lies between the second and the third.
  const auto around = [&](int cell, int count) {
    std::array<int, 4> numbers{};
    for (int k = 0; k < 4; ++k) {
      const int at = cell - 2 + k;
      const bool is_periodic = border_ == MapBorder::periodic;
      numbers[static_cast<std::size_t>(k)] =
          is_periodic ? ((at % count) + count) % count : std::clamp(at, 0, count - 1);
    }
    return numbers;
  };
  const std::array<int, 4> columns = around(x.cell, columns_), rows = around(y.cell, rows_);
  double samples[4][4];
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < 4; ++i) samples[j][i] = sample(columns[i], rows[j]);
  }
  const auto right = [&](int j) {
    return between(samples[j][2] - samples[j][0], samples[j][3] - samples[j][1], x.fraction);
  };
  const auto down = [&](int i) {
    return between(samples[2][i] - samples[0][i], samples[3][i] - samples[1][i], y.fraction);
  };
  const double step = scale_ / most_ / 2;
  return {step * between(right(1), right(2), y.fraction) * columns_,
          -step * between(down(1), down(2), x.fraction) * rows_};
}

DisplacementMap raise_heights(const DisplacementMap& map, double height) {
  if (map.whole_samples().empty()) {
    std::vector<float> heights = map.float_samples();
    const auto step = static_cast<float>(height);
    for (float& h : heights) h += step;
    return DisplacementMap(map.columns(), map.rows(), std::move(heights), map.border());
  }
  Raster samples;
  samples.width = map.columns();
  samples.height = map.rows();
  samples.bits = map.bits();
  samples.samples = map.whole_samples();
  return DisplacementMap(std::move(samples), map.scale(), map.offset() + height, map.border());
}

}  // namespace recede
