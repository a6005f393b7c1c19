// Points in cells, to find those near a segment.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace recede::detail {

class PointGrid {
 public:
  /// About as many cells along the longest side of their box as are given.
  PointGrid(const std::vector<Vec3>& points, int cells) {
    for (const Vec3& point : points) box_.extend(point);
    const double longest = points.empty() ? 1.0 : box_.sizes().maxCoeff();
    cell_ = longest > 0 ? longest / cells : 1.0;
    for (std::size_t i = 0; i < points.size(); ++i)
      cells_[key(cell_of(points[i]))].push_back(static_cast<Index>(i));
  }

  /// Calls `visit(i)` for all points within `distance` of a segment, and for some others, and may do so
  /// twice.
  template <typename Visit>
  void each_near(const Vec3& a, const Vec3& b, double distance, Visit&& visit) const {
    // In parts, so that the boxes of slanting ones hold few cells.
    const int parts = 1 + static_cast<int>((b - a).lpNorm<Eigen::Infinity>() / (4 * cell_));
    for (int i = 0; i < parts; ++i) {
      const double from = static_cast<double>(i) / parts, to = static_cast<double>(i + 1) / parts;
      each_near_part(a + from * (b - a), a + to * (b - a), distance, visit);
    }
  }

 private:
  using Cell = std::array<std::int64_t, 3>;

  template <typename Visit>
  void each_near_part(const Vec3& a, const Vec3& b, double distance, Visit& visit) const {
    const Vec3 reach = Vec3::Constant(distance);
    const Cell first = cell_of((a.cwiseMin(b) - reach).cwiseMax(box_.min()).cwiseMin(box_.max()));
    const Cell last = cell_of((a.cwiseMax(b) + reach).cwiseMax(box_.min()).cwiseMin(box_.max()));
    for (std::int64_t x = first[0]; x <= last[0]; ++x) {
      for (std::int64_t y = first[1]; y <= last[1]; ++y) {
        for (std::int64_t z = first[2]; z <= last[2]; ++z) {
          const auto found = cells_.find(key({x, y, z}));
          if (found == cells_.end()) continue;
          for (const Index i : found->second) visit(i);
        }
      }
    }
  }

  Cell cell_of(const Vec3& point) const {
    Cell cell;
    for (int axis = 0; axis < 3; ++axis)
      cell[static_cast<std::size_t>(axis)] =
          static_cast<std::int64_t>((point[axis] - box_.min()[axis]) / cell_);
    return cell;
  }
  static std::int64_t key(const Cell& cell) { return (cell[0] << 40) | (cell[1] << 20) | cell[2]; }

  Box3 box_;
  double cell_ = 1;
  std::unordered_map<std::int64_t, std::vector<Index>> cells_;
};

}  // namespace recede::detail
