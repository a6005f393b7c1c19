// A surface as a tree of parts, each with its area, centroid and second moments.
#pragma once

#include <recede/geometry/polygon_soup.h>
#include <recede/shells/detail/lp_kernel.h>

#include <array>
#include <cstddef>
#include <vector>

namespace recede::detail {

/// A triangle, or a point of some mass by three equal corners.
struct LpElement {
  std::array<Vec3, 3> corners;
  double mass;  ///< the triangle's area

  Vec3 centroid() const { return (corners[0] + corners[1] + corners[2]) / 3; }
};

/// When a part is summed up, and how.
struct LpTreeOptions {
  double p = 3;
  bool quadrupole = true;
  double opening = 1;
  double error = 0;  ///< instead of the opening, when it is above 0
};

struct LpTree {
  LpTree() = default;
  LpTree(std::vector<LpElement> elements, const LpTreeOptions& options);

  /// The first order of the expansion that is left out.
  int first_order_left_out() const { return quadrupole ? 3 : 2; }

  bool quadrupole = true;
  std::vector<LpNode> nodes;  ///< the root first
  std::vector<LpNodeExtent> extents;
  std::vector<LpBlock> blocks;
};

/// Of each node, for a support in the units of the tree.
std::vector<LpFade> fades_of(const LpTree& tree, double support);

}  // namespace recede::detail
