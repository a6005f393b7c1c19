// Filters of planes: a number for each pixel, row by row. A filter of two axes is one along rows and one
// along columns. Beyond the border the planes go on as they are at the border. Rows run in parallel; no sum
// depends on the number of threads.
#pragma once

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace recede::detail {

struct PlaneSize {
  int width = 0, height = 0;
  std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

/// `work(y, first)` for all rows, where `first` is the index of the row's first pixel.
template <typename Work>
void for_each_row(const PlaneSize& size, Work&& work) {
  tbb::parallel_for(0, size.height, [&](int y) {
    work(y, static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width));
  });
}

/// Of a symmetric or antisymmetric filter, whose middle is in the middle of an odd number of taps.
template <typename Number>
using Taps = std::vector<Number>;

template <typename Number>
void add_scaled(Number factor, const Number* from, Number* to, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) to[i] += factor * from[i];
}

template <typename Number>
std::vector<Number> filter_rows(const PlaneSize& size, const std::vector<Number>& plane,
                                const Taps<Number>& taps) {
  std::vector<Number> result(size.pixels());
  const std::size_t width = static_cast<std::size_t>(size.width), radius = taps.size() / 2;
  for_each_row(size, [&](int, std::size_t first) {
    std::vector<Number> row(width + 2 * radius);
    const Number* const begin = plane.data() + first;
    std::fill_n(row.begin(), radius, begin[0]);
    std::copy_n(begin, width, row.data() + radius);
    std::fill_n(row.data() + radius + width, radius, begin[width - 1]);
    for (std::size_t i = 0; i < taps.size(); ++i)
      add_scaled(taps[i], row.data() + i, result.data() + first, width);
  });
  return result;
}

template <typename Number>
std::vector<Number> filter_columns(const PlaneSize& size, const std::vector<Number>& plane,
                                   const Taps<Number>& taps) {
  std::vector<Number> result(size.pixels());
  const std::size_t width = static_cast<std::size_t>(size.width);
  const int radius = static_cast<int>(taps.size() / 2);
  for_each_row(size, [&](int y, std::size_t first) {
    for (int i = -radius; i <= radius; ++i) {
      const auto from = static_cast<std::size_t>(std::clamp(y + i, 0, size.height - 1));
      add_scaled(taps[static_cast<std::size_t>(i + radius)], plane.data() + from * width,
                 result.data() + first, width);
    }
  });
  return result;
}

}  // namespace recede::detail
