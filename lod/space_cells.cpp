#include <recede/lod/detail/space_cells.h>

#include <algorithm>

namespace recede::detail {

SpaceCells::SpaceCells(std::vector<Vec3> points, std::size_t most, double share) {
  add(points.begin(), points.end(), std::max<std::size_t>(most, 1), share, 0);
}

Index SpaceCells::add(std::vector<Vec3>::iterator first, std::vector<Vec3>::iterator last, std::size_t most,
                      double share, int depth) {
  constexpr int k_deepest = 48;  // points at one place can't be parted
  const auto number = static_cast<Index>(nodes_.size());
  nodes_.emplace_back();
  const auto n = static_cast<std::size_t>(last - first);
  Box3 box;
  for (auto p = first; p != last; ++p) box.extend(*p);
  Eigen::Index axis = 0;
  if (n <= most || depth == k_deepest || !(box.sizes().maxCoeff(&axis) > 0)) {
    nodes_[number].below = static_cast<Index>(n_cells_++);
    return number;
  }
  const auto middle =
      first + std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(share * static_cast<double>(n)), 1,
                                         static_cast<std::ptrdiff_t>(n) - 1);
  std::nth_element(first, middle, last, [&](const Vec3& p, const Vec3& q) { return p[axis] < q[axis]; });
  double at = (*middle)[axis];
  if (at == box.min()[axis]) {  // nothing would be below: the next place is the one
    at = box.max()[axis];
    for (auto p = first; p != last; ++p) {
      if ((*p)[axis] > box.min()[axis]) at = std::min(at, (*p)[axis]);
    }
  }
  const auto edge = std::partition(first, last, [&](const Vec3& p) { return p[axis] < at; });
  Node node{static_cast<int>(axis), at};
  node.below = add(first, edge, most, share, depth + 1);
  node.above = add(edge, last, most, share, depth + 1);
  nodes_[number] = node;
  return number;
}

Index SpaceCells::find(const Vec3& p) const {
  Index number = 0;
  while (nodes_[number].axis >= 0) {
    const Node& node = nodes_[number];
    number = p[node.axis] < node.at ? node.below : node.above;
  }
  return nodes_[number].below;
}

}  // namespace recede::detail
