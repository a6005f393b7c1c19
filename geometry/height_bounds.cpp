// The pyramid of least and largest heights.
#include <recede/geometry/displacement_map.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede {
namespace {

constexpr std::size_t k_nodes_of_a_task = 1 << 15;  // below it, starting a task costs more than it saves

std::size_t rows_of_a_task(int columns) {
  return std::max<std::size_t>(1, k_nodes_of_a_task / static_cast<std::size_t>(columns));
}

/// The least and the largest of some rows of samples, column by column.
template <typename Sample>
class ColumnRanges {
 public:
  explicit ColumnRanges(std::size_t columns) : min_(columns + 2), max_(columns + 2), columns_(columns) {}

  /// `rows` are not more than three pointers to rows; entry k + 1 becomes the range of texel column k.
  void set(const Sample* a, const Sample* b, const Sample* c, std::size_t before, std::size_t after) {
    Sample *const min = min_.data() + 1, *const max = max_.data() + 1;
    for (std::size_t x = 0; x < columns_; ++x) {
      min[x] = std::min(std::min(a[x], b[x]), c[x]);
      max[x] = std::max(std::max(a[x], b[x]), c[x]);
    }
    min_.front() = min[before];
    max_.front() = max[before];
    min_.back() = min[after];
    max_.back() = max[after];
  }
  const std::vector<Sample>& min() const { return min_; }
  const std::vector<Sample>& max() const { return max_; }

 private:
  std::vector<Sample> min_, max_;
  std::size_t columns_;
};

}  // namespace

HeightBounds::HeightBounds(const DisplacementMap& map) : map_(&map) {
  Level level{map.columns() + 1, map.rows() + 1, 0};
  levels_.push_back(level);
  std::size_t nodes = 0;
  while (level.columns > 1 || level.rows > 1) {
    level = {(level.columns + 1) / 2, (level.rows + 1) / 2, nodes};
    nodes += static_cast<std::size_t>(level.columns) * static_cast<std::size_t>(level.rows);
    levels_.push_back(level);
  }
  if (map.whole_samples().empty()) {
    floats_.resize(nodes);
    build(map.float_samples(), floats_);
  } else {
    whole_.resize(nodes);
    build(map.whole_samples(), whole_);
  }
}

template <typename Sample>
void HeightBounds::build(const std::vector<Sample>& samples, std::vector<Pair<Sample>>& pairs) {
  build_first_level(samples, pairs);
  for (std::size_t l = 2; l < levels_.size(); ++l) {
    const Level &fine = levels_[l - 1], &coarse = levels_[l];
    const auto rows = tbb::blocked_range<int>(0, coarse.rows, rows_of_a_task(coarse.columns));
    tbb::parallel_for(rows, [&](const tbb::blocked_range<int>& range) {
      for (int y = range.begin(); y != range.end(); ++y) {
        const auto row = [&](int fine_y) {
          return pairs.data() + fine.first +
                 static_cast<std::size_t>(fine_y) * static_cast<std::size_t>(fine.columns);
        };
        const Pair<Sample>*a = row(2 * y), *b = row(std::min(2 * y + 1, fine.rows - 1));
        Pair<Sample>* to = pairs.data() + coarse.first +
                           static_cast<std::size_t>(y) * static_cast<std::size_t>(coarse.columns);
        for (int x = 0; x < coarse.columns; ++x) {
          const int left = 2 * x, right = std::min(2 * x + 1, fine.columns - 1);
          to[x] = {std::min(std::min(a[left].min, a[right].min), std::min(b[left].min, b[right].min)),
                   std::max(std::max(a[left].max, a[right].max), std::max(b[left].max, b[right].max))};
        }
      }
    });
  }
}

template <typename Sample>
void HeightBounds::build_first_level(const std::vector<Sample>& samples,
                                     std::vector<Pair<Sample>>& pairs) const {
  const Level& level = levels_[1];  // a map has at least 2 x 2 cells
  const auto columns = static_cast<std::size_t>(map_->columns());
  const auto row = [&](int k) {
    return samples.data() + static_cast<std::size_t>(map_->row(std::min(k, map_->rows()))) * columns;
  };
  const auto before = static_cast<std::size_t>(map_->column(-1));
  const auto after = static_cast<std::size_t>(map_->column(map_->columns()));
  const auto rows = tbb::blocked_range<int>(0, level.rows, rows_of_a_task(level.columns));
  tbb::parallel_for(rows, [&](const tbb::blocked_range<int>& range) {
    ColumnRanges<Sample> ranges(columns);
    for (int y = range.begin(); y != range.end(); ++y) {
      // The cells of the rows 2y and 2y + 1 have their corners in three rows of texels.
      ranges.set(row(2 * y - 1), row(2 * y), row(2 * y + 1), before, after);
      const Sample *min = ranges.min().data(), *max = ranges.max().data();
      Pair<Sample>* to = pairs.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(level.columns);
      for (std::size_t x = 0; x < (columns + 1) / 2; ++x, min += 2, max += 2) {
        to[x] = {std::min(std::min(min[0], min[1]), min[2]), std::max(std::max(max[0], max[1]), max[2])};
      }
      if (columns % 2 == 0) to[columns / 2] = {std::min(min[0], min[1]), std::max(max[0], max[1])};
    }
  });
}

HeightBounds::Samples HeightBounds::samples_of_node(int level, int x, int y) const {
  if (level == 0) {
    const int left = map_->column(x - 1), right = map_->column(x);
    const int upper = map_->row(y - 1), lower = map_->row(y);
    const double a = map_->sample(left, upper), b = map_->sample(right, upper);
    const double c = map_->sample(left, lower), d = map_->sample(right, lower);
    return {std::min(std::min(a, b), std::min(c, d)), std::max(std::max(a, b), std::max(c, d))};
  }
  const Level& at = levels_[static_cast<std::size_t>(level)];
  const std::size_t index = at.first + static_cast<std::size_t>(y) * static_cast<std::size_t>(at.columns) +
                            static_cast<std::size_t>(x);
  if (whole_.empty()) return {floats_[index].min, floats_[index].max};
  return {static_cast<double>(whole_[index].min), static_cast<double>(whole_[index].max)};
}

HeightRange HeightBounds::heights(const Samples& samples) const {
  const double a = map_->height_of(samples.min), b = map_->height_of(samples.max);
  return {std::min(a, b), std::max(a, b)};
}

/// Adds those cells of the rectangle that lie in the node. Nodes that can't widen the range aren't opened.
void HeightBounds::extend(Samples& range, const CellRectangle& cells, int level, int x, int y) const {
  const int first_x = x << level, first_y = y << level;
  const int last_x = std::min((x + 1) << level, columns(0)) - 1;
  const int last_y = std::min((y + 1) << level, rows(0)) - 1;
  if (first_x > cells.x1 || last_x < cells.x0 || first_y > cells.y1 || last_y < cells.y0) return;
  const Samples node = samples_of_node(level, x, y);
  if (node.min >= range.min && node.max <= range.max) return;
  if (first_x >= cells.x0 && last_x <= cells.x1 && first_y >= cells.y0 && last_y <= cells.y1) {
    range = {std::min(range.min, node.min), std::max(range.max, node.max)};
    return;
  }
  for (int child = 0; child < 4; ++child) {
    const int child_x = 2 * x + child % 2, child_y = 2 * y + child / 2;
    if (child_x < columns(level - 1) && child_y < rows(level - 1)) {
      extend(range, cells, level - 1, child_x, child_y);
    }
  }
}

HeightBounds::Samples HeightBounds::samples_of(const CellRectangle& cells) const {
  Samples range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  extend(range, cells, levels() - 1, 0, 0);
  return range;
}

HeightRange HeightBounds::of_cells(int x0, int y0, int x1, int y1) const {
  return heights(samples_of({x0, y0, x1, y1}));
}

HeightRange HeightBounds::quick(int x0, int y0, int x1, int y1) const {
  int level = 0;
  while ((x1 >> level) - (x0 >> level) > 1 || (y1 >> level) - (y0 >> level) > 1) ++level;
  Samples range = samples_of_node(level, x0 >> level, y0 >> level);
  for (int y = y0 >> level; y <= y1 >> level; ++y) {
    for (int x = x0 >> level; x <= x1 >> level; ++x) {
      const Samples node = samples_of_node(level, x, y);
      range = {std::min(range.min, node.min), std::max(range.max, node.max)};
    }
  }
  return heights(range);
}

namespace {

/// Cells along one axis: one or two runs of them.
struct Runs {
  int count = 1;
  struct {
    int first, last;
  } run[2] = {};
};

/// From the place of `least` to that of `largest`; `n` texels, periodic.
Runs periodic_runs(double least, int first, double largest, int last, int n) {
  const double periods = std::floor(largest) - std::floor(least);
  // Cells 0 and n are the same one. The comparison also holds where periods are past counting.
  if (!(periods * n + last - first < n)) return {1, {{0, n}, {}}};
  last += static_cast<int>(periods) * n;
  if (last <= n) return {1, {{first, last}, {}}};
  return {2, {{first, n}, {0, last - n}}};
}

}  // namespace

HeightRange HeightBounds::of_box(const Vec2& least, const Vec2& largest) const {
  Runs across{1, {{map_->column_place(least.x()).cell, map_->column_place(largest.x()).cell}, {}}};
  Runs down{1, {{map_->row_place(largest.y()).cell, map_->row_place(least.y()).cell}, {}}};
  if (map_->border() == MapBorder::periodic) {
    across = periodic_runs(least.x(), across.run[0].first, largest.x(), across.run[0].last, map_->columns());
    down = periodic_runs(1 - largest.y(), down.run[0].first, 1 - least.y(), down.run[0].last, map_->rows());
  }
  Samples range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (int i = 0; i < across.count; ++i) {
    for (int j = 0; j < down.count; ++j) {
      const CellRectangle cells{across.run[i].first, down.run[j].first, across.run[i].last, down.run[j].last};
      extend(range, cells, levels() - 1, 0, 0);
    }
  }
  return heights(range);
}

}  // namespace recede
