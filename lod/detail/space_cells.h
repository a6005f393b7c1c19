// Space cut into cells, for work on a surface a piece at a time.
#pragma once

#include <recede/geometry/closest_point.h>
#include <recede/geometry/detail/cut_triangle.h>

#include <vector>

namespace recede::detail {

/// Cells between planes across the axes, all of space together.
class SpaceCells {
 public:
  /// Every cell holds at most `most` of the points, but for points at one place. Each plane leaves `share` of
  /// the points that it parts below it, 0 to 1: cells of another share have other planes.
  SpaceCells(std::vector<Vec3> points, std::size_t most, double share);

  std::size_t size() const { return n_cells_; }
  Index find(const Vec3& p) const;

  /// Calls `visit(cell, Triangle)` for pieces that cover the triangle, each in one cell.
  template <typename Visit>
  void cut(const Triangle& triangle, Visit&& visit) const {
    cut_below(0, triangle, visit);
  }

 private:
  struct Node {
    int axis = -1;  ///< -1: a cell
    double at = 0;
    Index below = 0, above = 0;  ///< nodes; of a cell its number in `below`
  };

  Index add(std::vector<Vec3>::iterator first, std::vector<Vec3>::iterator last, std::size_t most,
            double share, int depth);

  template <typename Visit>
  void cut_below(Index number, const Triangle& t, Visit&& visit) const {
    const Node& node = nodes_[number];
    if (node.axis < 0) return visit(node.below, t);
    const std::array<double, 3> heights{t.a[node.axis] - node.at, t.b[node.axis] - node.at,
                                        t.c[node.axis] - node.at};
    const auto [low, high] = std::minmax({heights[0], heights[1], heights[2]});
    if (high < 0) return cut_below(node.below, t, visit);
    if (low >= 0) return cut_below(node.above, t, visit);
    cut_triangle(t, heights, [&](const Triangle& part, bool is_above) {
      cut_below(is_above ? node.above : node.below, part, visit);
    });
  }

  std::vector<Node> nodes_;
  std::size_t n_cells_ = 0;
};

}  // namespace recede::detail
