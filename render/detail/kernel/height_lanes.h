// Heights and their ranges for several places at once.
#pragma once

#include <recede/render/detail/displaced_kernel.h>
#include <recede/render/detail/kernel/float_lanes.h>

namespace recede::detail {
namespace {

struct Range4 {
  Float4 low, high;
};

template <typename Sample>
struct NodeRange {
  Sample min, max;
};

template <typename Sample>
class HeightMap {
 public:
  HeightMap(const HeightMapView& view, float fraction)
      : view_(view), offset_(view.offset * fraction), scale_(view.scale * fraction) {
    if constexpr (sizeof(Sample) == sizeof(float)) {
      samples_ = view.floats;
    } else {
      samples_ = view.whole;
    }
  }

  float room() const { return view_.height_room; }
  float height(float sample) const { return offset_ + scale_ * sample; }
  Float8 heights(Float8 samples) const { return offset_ + scale_ * samples; }
  Range4 heights(const Range4& samples) const {
    const Float4 a = offset_ + scale_ * samples.low, b = offset_ + scale_ * samples.high;
    return {least(a, b), largest(a, b)};
  }

  // Samples over four rectangles at once.
  RECEDE_INLINE Range4 ranges(Float4 x_min, Float4 x_max, Float4 y_min, Float4 y_max) const {
    const Float4 columns = all4(static_cast<float>(view_.columns)),
                 rows = all4(static_cast<float>(view_.rows)), zero = all4(0);
    if (view_.is_periodic) {
      const Int4 inside = (x_min >= zero) & (x_max <= columns) & (y_min >= zero) & (y_max <= rows);
      if (sign_bits(inside) != 15) return wrapped_ranges(x_min, x_max, y_min, y_max);
    } else {
      x_min = least(largest(x_min, zero), columns);
      x_max = least(largest(x_max, zero), columns);
      y_min = least(largest(y_min, zero), rows);
      y_max = least(largest(y_max, zero), rows);
    }
    const Int4 x0 = truncated(x_min), y0 = truncated(y_min);
    // A rectangle that ends between two cells touches the first one only; masks are -1.
    Int4 x1 = truncated(x_max), y1 = truncated(y_max);
    x1 += (to_floats(x1) == x_max) & (x1 > x0);
    y1 += (to_floats(y1) == y_max) & (y1 > y0);
    return ranges_of_cells(x0, y0, x1, y1, level_of(any_bits((x1 - x0) | (y1 - y0))));
  }

  // Of one rectangle.
  __attribute__((noinline)) void extend(float x_min, float x_max, float y_min, float y_max, float& low,
                                        float& high) const {
    const Range4 range = ranges(all4(x_min), all4(x_max), all4(y_min), all4(y_max));
    low = low < range.low[0] ? low : range.low[0];
    high = high > range.high[0] ? high : range.high[0];
  }

  float bilinear_one(float x, float y) const {
    const AxisPlace column = column_place(x), row = row_place(y);
    const float s00 = at(column.first, row.first), s10 = at(column.second, row.first);
    const float s01 = at(column.first, row.second), s11 = at(column.second, row.second);
    const float upper = s00 * (1 - column.fraction) + s10 * column.fraction;
    const float lower = s01 * (1 - column.fraction) + s11 * column.fraction;
    return upper * (1 - row.fraction) + lower * row.fraction;
  }

  // Bilinear samples at eight places.
  Float8 bilinear(Float8 x, Float8 y) const {
    const Float8 one = all8(1), last_x = all8(static_cast<float>(view_.columns) - 0.5f),
                 last_y = all8(static_cast<float>(view_.rows) - 0.5f);
    const Int8 inside = (x >= one) & (x < last_x) & (y >= one) & (y < last_y);
    if (sign_bits(inside) != 255) {
      Float8 result;
      for (int k = 0; k < 8; ++k) result[k] = bilinear_one(x[k], y[k]);
      return result;
    }
    const Int8 column = truncated(x), row = truncated(y);
    const Float8 fx = x - to_floats(column), fy = y - to_floats(row);
    const Int8 first = (row - 1) * view_.columns + (column - 1);
    Float8 s00, s10, s01, s11;
    gather(samples_, first, s00, s10);
    gather(samples_ + view_.columns, first, s01, s11);
    const Float8 upper = s00 * (one - fx) + s10 * fx;
    const Float8 lower = s01 * (one - fx) + s11 * fx;
    return upper * (one - fy) + lower * fy;
  }

 private:
  // Texels before and after a place, and where it is between them.
  struct AxisPlace {
    int first, second;
    float fraction;
  };
  AxisPlace column_place(float x) const { return axis_place(x, view_.columns); }
  AxisPlace row_place(float y) const { return axis_place(y, view_.rows); }
  AxisPlace axis_place(float x, int count) const {
    if (!view_.is_periodic) {
      const float most = static_cast<float>(count);
      x = x < 1 ? 1 : x > most ? most : x;
    }
    const float floor = __builtin_floorf(x);
    int cell = static_cast<int>(floor);
    const float fraction = x - floor;
    if (!view_.is_periodic) return {cell - 1, cell < count ? cell : cell - 1, fraction};
    cell = modulo(cell, count);
    return {cell == 0 ? count - 1 : cell - 1, cell, fraction};
  }
  static int modulo(int a, int n) {
    const int rest = a % n;
    return rest < 0 ? rest + n : rest;
  }
  float at(int column, int row) const {
    return static_cast<float>(
        samples_[static_cast<std::size_t>(row) * static_cast<std::size_t>(view_.columns) +
                 static_cast<std::size_t>(column)]);
  }

#if defined(__AVX2__)
  static void gather(const std::uint16_t* samples, Int8 index, Float8& here, Float8& next) {
    const Int8 pairs = (Int8)_mm256_i32gather_epi32((const int*)samples, (__m256i)index, 2);
    here = to_floats(pairs & 0xffff);
    next = to_floats((Int8)_mm256_srli_epi32((__m256i)pairs, 16));
  }
#else
  static void gather(const std::uint16_t* samples, Int8 index, Float8& here, Float8& next) {
    for (int k = 0; k < 8; ++k) {
      here[k] = static_cast<float>(samples[index[k]]);
      next[k] = static_cast<float>(samples[index[k] + 1]);
    }
  }
#endif
  static void gather(const float* samples, Int8 index, Float8& here, Float8& next) {
    for (int k = 0; k < 8; ++k) {
      here[k] = samples[index[k]];
      next[k] = samples[index[k] + 1];
    }
  }

  int level_of(int extent) const {
    const int level = extent == 0 ? 0 : 32 - __builtin_clz(static_cast<unsigned>(extent));
    return level < view_.levels ? level : view_.levels - 1;
  }

  // Rectangles reach over at most two nodes of the level along either axis.
  RECEDE_INLINE Range4 ranges_of_cells(Int4 x0, Int4 y0, Int4 x1, Int4 y1, int level) const {
    if (level == 0) return ranges_of_single_cells(x0, y0);
    const int stride = view_.node_columns[level];
    const auto* nodes = static_cast<const NodeRange<Sample>*>(view_.nodes[level]);
    x0 >>= level;
    y0 >>= level;
    x1 >>= level;
    y1 >>= level;
    const Int4 first = y0 * stride + x0;
    Range4 range = node_ranges(nodes, first);
    const Int4 wide = x1 - x0, high = (y1 - y0) * stride;
    const auto add = [&](Int4 index) {
      const Range4 more = node_ranges(nodes, index);
      range = {least(range.low, more.low), largest(range.high, more.high)};
    };
    const bool any_wide = is_any(wide);
    if (any_wide) add(first + wide);
    if (is_any(high)) {
      add(first + high);
      if (any_wide) add(first + high + wide);
    }
    return range;
  }
  static RECEDE_INLINE Range4 node_ranges(const NodeRange<std::uint16_t>* nodes, Int4 index) {
    static_assert(sizeof(nodes[0]) == sizeof(int));
    int pair[4];
    for (int k = 0; k < 4; ++k) __builtin_memcpy(&pair[k], &nodes[index[k]], sizeof(int));
    const Int4 pairs = {pair[0], pair[1], pair[2], pair[3]};
    return {to_floats(pairs & 0xffff), to_floats((Int4)((UInt4)pairs >> 16))};
  }
  static RECEDE_INLINE Range4 node_ranges(const NodeRange<float>* nodes, Int4 index) {
    const NodeRange<float> a = nodes[index[0]], b = nodes[index[1]], c = nodes[index[2]], d = nodes[index[3]];
    return {Float4{a.min, b.min, c.min, d.min}, Float4{a.max, b.max, c.max, d.max}};
  }
  __attribute__((noinline)) Range4 ranges_of_single_cells(Int4 x, Int4 y) const {
    Range4 range;
    for (int k = 0; k < 4; ++k) {
      const int right = x[k] < view_.columns ? x[k] : (view_.is_periodic ? 0 : x[k] - 1);
      const int left = x[k] > 0 ? x[k] - 1 : (view_.is_periodic ? view_.columns - 1 : 0);
      const int below = y[k] < view_.rows ? y[k] : (view_.is_periodic ? 0 : y[k] - 1);
      const int above = y[k] > 0 ? y[k] - 1 : (view_.is_periodic ? view_.rows - 1 : 0);
      const float s[4] = {at(left, above), at(right, above), at(left, below), at(right, below)};
      range.low[k] = range.high[k] = s[0];
      for (int c = 1; c < 4; ++c) {
        range.low[k] = s[c] < range.low[k] ? s[c] : range.low[k];
        range.high[k] = s[c] > range.high[k] ? s[c] : range.high[k];
      }
    }
    return range;
  }

  // Rectangles that leave a periodic map, one by one: each is moved into it, and cut where it leaves again.
  __attribute__((noinline)) Range4 wrapped_ranges(Float4 x_min, Float4 x_max, Float4 y_min,
                                                  Float4 y_max) const {
    Range4 range;
    for (int k = 0; k < 4; ++k) {
      const Span columns = wrapped_cells(x_min[k], x_max[k], view_.columns);
      const Span rows = wrapped_cells(y_min[k], y_max[k], view_.rows);
      bool is_first = true;
      for (int piece = 0; piece < 4; ++piece) {
        const int x0 = piece & 1 ? 0 : columns.first, y0 = piece & 2 ? 0 : rows.first;
        const int x1 = piece & 1 ? columns.rest : columns.last, y1 = piece & 2 ? rows.rest : rows.last;
        if (x1 < x0 || y1 < y0) continue;
        const Int4 ends = Int4{x0, y0, x1, y1};
        const Range4 more = ranges_of_cells(all(ends[0]), all(ends[1]), all(ends[2]), all(ends[3]),
                                            level_of((x1 - x0) | (y1 - y0)));
        range.low[k] = is_first || more.low[0] < range.low[k] ? more.low[0] : range.low[k];
        range.high[k] = is_first || more.high[0] > range.high[k] ? more.high[0] : range.high[k];
        is_first = false;
      }
    }
    return range;
  }
  static Int4 all(int value) { return Int4{value, value, value, value}; }
  // Cells from first to last, and those from 0 to rest: -1 for none.
  struct Span {
    int first, last, rest;
  };
  static Span wrapped_cells(float low, float high, int count) {
    const int first = static_cast<int>(__builtin_floorf(low));
    int last = static_cast<int>(__builtin_ceilf(high)) - 1;
    if (last < first) last = first;
    if (last - first >= count) return {0, count - 1, -1};
    const int start = modulo(first, count), end = start + last - first;
    return {start, end < count ? end : count - 1, end < count ? -1 : end - count};
  }

  const HeightMapView& view_;
  const Sample* samples_ = nullptr;
  float offset_, scale_;
};

}  // namespace
}  // namespace recede::detail
