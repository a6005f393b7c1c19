// A hierarchy of boxes that finds all that overlap, and all that a ray along the first axis runs through.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <array>
#include <vector>

namespace recede::detail {

/// A complete binary tree over boxes, cut at medians: its depth is logarithmic whatever the boxes. The same
/// for any number of threads.
class BoxTree {
 public:
  struct Box {
    std::array<double, 3> lower, upper;

    bool overlaps(const Box& other) const {
      return lower[0] <= other.upper[0] && other.lower[0] <= upper[0] && lower[1] <= other.upper[1] &&
             other.lower[1] <= upper[1] && lower[2] <= other.upper[2] && other.lower[2] <= upper[2];
    }
    void extend(const Box& other);
  };

  explicit BoxTree(const std::vector<Box>& boxes);

  std::size_t n_leaves() const { return n_leaves_; }

  /// Calls `visit(i, j)` for boxes that overlap, the first one of `leaf` and each pair in just one of all
  /// leaves. Only pairs of which `is_active(number)` holds for one at least count; unless `is_selective` it
  /// holds for all.
  template <typename IsActive, typename Visit>
  void visit_pairs(std::size_t leaf, bool is_selective, IsActive&& is_active, Visit&& visit) const;

  /// Calls `visit(i)` for the boxes that the ray from `origin` towards larger first coordinates touches.
  template <typename Visit>
  void visit_ray(const Vec3& origin, Visit&& visit) const;

 private:
  struct Item {
    std::array<double, 3> center;
    Index number;
  };

  void build(std::vector<Item>& items, const std::vector<Box>& boxes, std::size_t node,
             std::size_t first_leaf, std::size_t n_leaves);
  /// Of the first box in a leaf.
  std::size_t begin(std::size_t leaf) const { return leaf * order_.size() / n_leaves_; }

  std::size_t n_leaves_ = 1;  // a power of two
  std::vector<Box> nodes_;    // the root at 1, the children of k at 2k and 2k + 1, the leaves last
  std::vector<Box> boxes_;    // leaf by leaf
  std::vector<Index> order_;  // the number of each in the list given
};

template <typename IsActive, typename Visit>
void BoxTree::visit_pairs(std::size_t leaf, bool is_selective, IsActive&& is_active, Visit&& visit) const {
  const std::size_t first = begin(leaf), last = begin(leaf + 1);
  bool any = false;
  for (std::size_t i = first; i < last; ++i) any = any || is_active(order_[i]);
  if (!any) return;
  const Box box = nodes_[n_leaves_ + leaf];
  std::array<std::size_t, 64> stack;
  std::size_t top = 0;
  if (is_selective) {
    stack[top++] = 1;
  } else {  // all that stands behind the leaf, and the leaf itself
    for (std::size_t node = n_leaves_ + leaf; node > 1; node /= 2) {
      if (node % 2 == 0) stack[top++] = node + 1;
    }
    stack[top++] = n_leaves_ + leaf;
  }
  while (top > 0) {
    const std::size_t node = stack[--top];
    if (!nodes_[node].overlaps(box)) continue;
    if (node < n_leaves_) {
      stack[top++] = 2 * node + 1;
      stack[top++] = 2 * node;
      continue;
    }
    const std::size_t other = node - n_leaves_, other_last = begin(other + 1);
    for (std::size_t j = begin(other); j < other_last; ++j) {
      if (!boxes_[j].overlaps(box)) continue;
      const bool is_other_active = is_active(order_[j]);
      for (std::size_t i = first; i < last; ++i) {
        // Pairs of two active boxes are found from both sides.
        if (!is_active(order_[i]) || (is_other_active && i >= j)) continue;
        if (boxes_[i].overlaps(boxes_[j])) visit(order_[i], order_[j]);
      }
    }
  }
}

template <typename Visit>
void BoxTree::visit_ray(const Vec3& origin, Visit&& visit) const {
  const auto is_touched = [&](const Box& box) {
    return box.upper[0] >= origin.x() && box.lower[1] <= origin.y() && origin.y() <= box.upper[1] &&
           box.lower[2] <= origin.z() && origin.z() <= box.upper[2];
  };
  std::array<std::size_t, 64> stack;
  std::size_t top = 0;
  stack[top++] = 1;
  while (top > 0) {
    const std::size_t node = stack[--top];
    if (!is_touched(nodes_[node])) continue;
    if (node < n_leaves_) {
      stack[top++] = 2 * node + 1;
      stack[top++] = 2 * node;
      continue;
    }
    const std::size_t leaf = node - n_leaves_;
    for (std::size_t i = begin(leaf); i < begin(leaf + 1); ++i) {
      if (is_touched(boxes_[i])) visit(order_[i]);
    }
  }
}

}  // namespace recede::detail
