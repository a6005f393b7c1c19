// A triangle with corners in whole voxels, cut into small triangles of about a voxel by a sweep.
//
// Source: see grid_space.h. Its walk over cells with twelve registers leaves some cases
// open; here columns of vertices are joined instead, which gives the same vertices and needs no special
// cases.
#pragma once

#include <recede/lod/detail/grid_space.h>

#include <vector>

namespace recede::detail {

/// How a triangle is swept: from corner `a` to corner `b` of its longest primary edge, in the
/// coordinate plane that shows the most of it.
struct SweepPlan {
  std::size_t a = 0, b = 1, c = 2;  ///< corners; c lies above the edge a b, or on it
  std::size_t sweep = 0, side = 1;  ///< axes
  std::int32_t upwards = 1;         ///< sign of the side axis
  bool is_flat = false;             ///< no area in any plane with the sweep axis
  bool is_reversed = false;         ///< a, b, c run the other way round than the corners 0, 1, 2
};
/// Every triangle has a primary edge: one along whose main direction the third corner lies between its ends
/// (theorem 1). Ties: the axis x before y before z, then the edge.
SweepPlan plan_sweep(const std::array<GridPoint, 3>& corners);

/// About how many small triangles there will be: twice the area in the plane of the sweep, signed.
std::int64_t twice_area(const std::array<GridPoint, 3>& corners, std::size_t x_axis, std::size_t y_axis);

/// Small triangles of one triangle after another; memory is kept in between.
///
/// Vertices have numbers: the corners 0, 1, 2; then the inner ones of the edges 0 1, 1 2 and 2 0, in that
/// direction; then those inside, column by column. Edges have as many pieces as voxels along their main
/// direction, and their vertices depend on the two ends alone.
class GridSweep {
 public:
  void set(const std::array<GridPoint, 3>& corners);

  const SweepPlan& plan() const { return plan_; }
  std::size_t n_border() const { return n_border_; }
  std::size_t n_inside() const { return nodes_.size() - n_border_; }
  /// Of all small triangles: they cover a disk.
  std::size_t n_triangles() const { return n_border_ + 2 * n_inside() - 2; }
  /// Inner vertices of the edge from corner k to the next, and the number of the first one.
  std::size_t n_on_edge(std::size_t k) const { return on_edge_[k]; }
  std::size_t first_on_edge(std::size_t k) const { return first_on_edge_[k]; }

  /// Where a vertex lies in the plane of the sweep, voxels; upwards is positive.
  struct Node {
    double sweep = 0, side = 0;
  };
  const Node& node(std::size_t vertex) const { return nodes_[vertex]; }

  /// Weights of corners a, b and c at a place of the plane, and what a step along both axes adds to those of
  /// b and c. Not for flat triangles, which have no vertices inside.
  struct Weights {
    double a, b, c;
  };
  Weights weights(const Node& at) const;
  struct Steps {
    double b_sweep, b_side, c_sweep, c_side;
  };
  Steps steps() const;

  /// Calls `emit(i, j, k)` with the numbers of each small triangle's vertices, in the direction of the
  /// corners.
  template <typename Emit>
  void triangulate(Emit&& emit);

 private:
  using Chain = std::vector<std::uint32_t>;
  void place_edge(std::size_t k, const std::array<GridPoint, 3>& corners);
  void append_edge(Chain& chain, std::size_t from, std::size_t to) const;
  void place_inside();
  /// The part of `rest_` in a column.
  struct Run {
    std::size_t first, last;
  };
  Run run_from(std::size_t first) const;
  void build_column(std::size_t column, const Run& run);

  template <typename Key, typename Emit>
  void zip(const Chain& left, const Chain& right, Key&& key, Emit&& emit) const;

  SweepPlan plan_;
  std::size_t n_border_ = 0;
  std::array<std::size_t, 3> on_edge_{}, first_on_edge_{};
  Node origin_;       // of weights: corner a
  Node to_b_, to_c_;  // from there
  double twice_area_ = 1;
  std::vector<Node> nodes_;
  Chain primary_, rest_;                     // from a to b, directly and by c
  std::vector<std::uint32_t> column_first_;  // number of the first vertex inside of each column
  Chain left_, right_, before_, cap_left_, cap_right_;
};

template <typename Key, typename Emit>
void GridSweep::zip(const Chain& left, const Chain& right, Key&& key, Emit&& emit) const {
  std::size_t i = 0, j = 0;
  while (i + 1 < left.size() || j + 1 < right.size()) {
    const bool from_left =
        j + 1 >= right.size() || (i + 1 < left.size() && key(left[i + 1]) <= key(right[j + 1]));
    const std::uint32_t x = left[i], y = right[j], z = from_left ? left[i + 1] : right[j + 1];
    ++(from_left ? i : j);
    if (x == y || y == z || z == x) continue;
    if (plan_.is_reversed)
      emit(y, x, z);
    else
      emit(x, y, z);
  }
}

template <typename Emit>
void GridSweep::triangulate(Emit&& emit) {
  if (plan_.is_flat)
    return zip(
        rest_, primary_, [&](std::uint32_t v) { return nodes_[v].sweep; }, emit);
  const auto height = [&](std::uint32_t v) { return nodes_[v].side; };
  Run run = run_from(0);
  before_.assign(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(run.last) + 1);
  for (std::size_t column = 1; column < primary_.size(); ++column) {
    run = run_from(run.last + 1);
    if (column + 1 < primary_.size()) {
      build_column(column, run);
      zip(before_, right_, height, emit);
      if (cap_left_.size() + cap_right_.size() > 4) zip(cap_left_, cap_right_, height, emit);
      before_.swap(left_);
    } else {  // the last: from b downwards along the rest
      right_.clear();
      for (std::size_t i = run.last + 1; i-- > run.first;) right_.push_back(rest_[i]);
      zip(before_, right_, height, emit);
    }
  }
}

}  // namespace recede::detail
