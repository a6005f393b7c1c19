#include <recede/shells/detail/box_tree.h>

#include <tbb/parallel_invoke.h>

#include <algorithm>

namespace recede::detail {
namespace {

constexpr std::size_t k_leaf_size = 4;
constexpr std::size_t k_parallel_leaves = 1024;  // below this, a thread takes more time than it saves

}  // namespace

BoxTree::BoxTree(const std::vector<Box>& boxes)
    : boxes_(boxes.size()), order_(boxes.size()), place_(boxes.size()) {
  while (n_leaves_ * k_leaf_size < boxes.size()) n_leaves_ *= 2;
  std::vector<Item> items(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    items[i].number = static_cast<Index>(i);
    for (std::size_t k = 0; k < 3; ++k) {
      items[i].center[k] = 0.5 * boxes[i].lower[k] + 0.5 * boxes[i].upper[k];
    }
  }
  nodes_.resize(2 * n_leaves_);
  build(items, boxes, 1, 0, n_leaves_);
  for (std::size_t i = 0; i < order_.size(); ++i) place_[order_[i]] = static_cast<Index>(i);
}

std::size_t BoxTree::leaf_of(Index i) const {
  // The leaf whose first box is the last one up to this place.
  std::size_t leaf = place_[i] * n_leaves_ / order_.size();
  while (leaf + 1 < n_leaves_ && begin(leaf + 1) <= place_[i]) ++leaf;
  return leaf;
}

void BoxTree::move(Index i, const Box& box) {
  boxes_[place_[i]] = box;
  const std::size_t leaf = leaf_of(i);
  Box around = nothing();
  for (std::size_t k = begin(leaf); k < begin(leaf + 1); ++k) around.extend(boxes_[k]);
  nodes_[n_leaves_ + leaf] = around;
  for (std::size_t node = (n_leaves_ + leaf) / 2; node > 0; node /= 2) {
    nodes_[node] = nodes_[2 * node];
    nodes_[node].extend(nodes_[2 * node + 1]);
  }
}

/// The place of a cut follows from the number of leaves alone, so that all writes are to known places.
void BoxTree::build(std::vector<Item>& items, const std::vector<Box>& boxes, std::size_t node,
                    std::size_t first_leaf, std::size_t n_leaves) {
  const std::size_t first = begin(first_leaf), last = begin(first_leaf + n_leaves);
  Box& box = nodes_[node];
  box = nothing();
  if (n_leaves == 1) {
    for (std::size_t i = first; i < last; ++i) {
      order_[i] = items[i].number;
      boxes_[i] = boxes[items[i].number];
      box.extend(boxes_[i]);
    }
    return;
  }
  Box centers = box;
  for (std::size_t i = first; i < last; ++i) centers.extend({items[i].center, items[i].center});
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if (centers.upper[k] - centers.lower[k] > centers.upper[axis] - centers.lower[axis]) axis = k;
  }
  const auto place = [&](std::size_t i) { return items.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(
      place(first), place(begin(first_leaf + n_leaves / 2)), place(last), [&](const Item& a, const Item& b) {
        return a.center[axis] != b.center[axis] ? a.center[axis] < b.center[axis] : a.number < b.number;
      });
  const auto left = [&] { build(items, boxes, 2 * node, first_leaf, n_leaves / 2); };
  const auto right = [&] { build(items, boxes, 2 * node + 1, first_leaf + n_leaves / 2, n_leaves / 2); };
  if (n_leaves >= k_parallel_leaves) {
    tbb::parallel_invoke(left, right);
  } else {
    left();
    right();
  }
  box.extend(nodes_[2 * node]);
  box.extend(nodes_[2 * node + 1]);
}

}  // namespace recede::detail
