// A hierarchy of boxes that finds all that overlap, and all that a ray along the first axis runs through.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <algorithm>
#include <array>
#include <limits>
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
    void extend(const Box& other) {
      for (std::size_t k = 0; k < 3; ++k) {
        lower[k] = std::min(lower[k], other.lower[k]);
        upper[k] = std::max(upper[k], other.upper[k]);
      }
    }
  };

  explicit BoxTree(const std::vector<Box>& boxes);

  std::size_t n_leaves() const { return n_leaves_; }

  /// Where box `i` is.
  std::size_t leaf_of(Index i) const;

  /// Box `i` is another one now. The tree stays as it was cut, so that boxes which move far make it slow.
  void move(Index i, const Box& box);

  /// Calls `visit(i, j)` for boxes that overlap, the first one of `leaf`: each pair in one of all leaves.
  template <typename Visit>
  void visit_pairs(std::size_t leaf, Visit&& visit) const;

  /// Calls `visit(i, j)` for boxes that overlap, the first one a selected one of `leaf`: of two that are
  /// selected, once in all leaves.
  template <typename IsSelected, typename Visit>
  void visit_selected_pairs(std::size_t leaf, IsSelected&& is_selected, Visit&& visit) const;

  /// Calls `visit(i)` for the boxes that overlap `box`.
  template <typename Visit>
  void visit_overlaps(const Box& box, Visit&& visit) const;

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
  static Box nothing() {
    constexpr double k_far = std::numeric_limits<double>::infinity();
    return {{k_far, k_far, k_far}, {-k_far, -k_far, -k_far}};
  }
  struct Stack {
    std::array<std::size_t, 64> nodes;  // two for each level, of which there are 32 at most
    std::size_t size = 0;
    void push(std::size_t node) { nodes[size++] = node; }
  };
  template <typename IsMet, typename VisitLeaf>
  void descend(Stack& stack, IsMet&& is_met, VisitLeaf&& visit_leaf) const;
  template <typename IsMet, typename Visit>
  void visit_met(IsMet&& is_met, Visit&& visit) const;

  /// Of the first box in a leaf.
  std::size_t begin(std::size_t leaf) const { return leaf * order_.size() / n_leaves_; }

  std::size_t n_leaves_ = 1;  // a power of two
  std::vector<Box> nodes_;    // the root at 1, the children of k at 2k and 2k + 1, the leaves last
  std::vector<Box> boxes_;    // leaf by leaf
  std::vector<Index> order_;  // the number of each in the list given
  std::vector<Index> place_;  // of each in that list: where it is here
};

template <typename IsMet, typename VisitLeaf>
void BoxTree::descend(Stack& stack, IsMet&& is_met, VisitLeaf&& visit_leaf) const {
  while (stack.size > 0) {
    const std::size_t node = stack.nodes[--stack.size];
    if (!is_met(nodes_[node])) continue;
    if (node < n_leaves_) {
      stack.push(2 * node + 1);
      stack.push(2 * node);
    } else {
      visit_leaf(node - n_leaves_);
    }
  }
}

template <typename Visit>
void BoxTree::visit_pairs(std::size_t leaf, Visit&& visit) const {
  const std::size_t first = begin(leaf), last = begin(leaf + 1);
  const Box box = nodes_[n_leaves_ + leaf];
  Stack stack;  // all that stands behind the leaf, and the leaf itself
  for (std::size_t node = n_leaves_ + leaf; node > 1; node /= 2) {
    if (node % 2 == 0) stack.push(node + 1);
  }
  stack.push(n_leaves_ + leaf);
  const auto overlaps = [&](const Box& other) { return other.overlaps(box); };
  descend(stack, overlaps, [&](std::size_t other) {
    for (std::size_t j = begin(other); j < begin(other + 1); ++j) {
      if (!boxes_[j].overlaps(box)) continue;
      for (std::size_t i = first; i < std::min(last, j); ++i) {
        if (boxes_[i].overlaps(boxes_[j])) visit(order_[i], order_[j]);
      }
    }
  });
}

template <typename IsSelected, typename Visit>
void BoxTree::visit_selected_pairs(std::size_t leaf, IsSelected&& is_selected, Visit&& visit) const {
  const std::size_t first = begin(leaf), last = begin(leaf + 1);
  Box box = nothing();
  for (std::size_t i = first; i < last; ++i) {
    if (is_selected(order_[i])) box.extend(boxes_[i]);
  }
  Stack stack;
  stack.push(1);
  const auto overlaps = [&](const Box& other) { return other.overlaps(box); };
  descend(stack, overlaps, [&](std::size_t other) {
    for (std::size_t j = begin(other); j < begin(other + 1); ++j) {
      if (!boxes_[j].overlaps(box)) continue;
      const bool finds_as_well = is_selected(order_[j]);
      for (std::size_t i = first; i < last; ++i) {
        if (i == j || (finds_as_well && i > j) || !is_selected(order_[i])) continue;
        if (boxes_[i].overlaps(boxes_[j])) visit(order_[i], order_[j]);
      }
    }
  });
}

template <typename Visit>
void BoxTree::visit_overlaps(const Box& box, Visit&& visit) const {
  visit_met([&](const Box& other) { return other.overlaps(box); }, visit);
}

template <typename Visit>
void BoxTree::visit_ray(const Vec3& origin, Visit&& visit) const {
  const auto is_touched = [&](const Box& box) {
    return box.upper[0] >= origin.x() && box.lower[1] <= origin.y() && origin.y() <= box.upper[1] &&
           box.lower[2] <= origin.z() && origin.z() <= box.upper[2];
  };
  visit_met(is_touched, visit);
}

template <typename IsMet, typename Visit>
void BoxTree::visit_met(IsMet&& is_met, Visit&& visit) const {
  Stack stack;
  stack.push(1);
  descend(stack, is_met, [&](std::size_t leaf) {
    for (std::size_t i = begin(leaf); i < begin(leaf + 1); ++i) {
      if (is_met(boxes_[i])) visit(order_[i]);
    }
  });
}

}  // namespace recede::detail
