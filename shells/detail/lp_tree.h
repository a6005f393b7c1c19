// A surface as a tree of parts, each with its area, centroid and second moments.
#pragma once

#include <recede/geometry/polygon_soup.h>

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

inline constexpr std::size_t k_lp_lanes = 4;  ///< children of a node, elements of a leaf
inline constexpr Index k_lp_leaf_bit = 0x80000000u;

/// Four children side by side: one visit reads one place in memory, and the four are summed up at once.
/// Lanes without a child have no mass, and count as far.
struct LpNode {
  double x[k_lp_lanes], y[k_lp_lanes], z[k_lp_lanes];  ///< centroids
  double squared_reach[k_lp_lanes];  ///< the child may be summed up where it's farther than this
  double mass[k_lp_lanes];
  /// With r the vector from the centroid: what the child adds to I_p is
  /// |r|^-p (mass + |r|^-4 r.(tensor r)); xx, yy, zz, xy, xz, yz.
  double tensor[6][k_lp_lanes];
  Index child[k_lp_lanes];  ///< a node, or leaf bit and block
};

/// What only bounds and supports ask for.
struct LpNodeExtent {
  double radius[k_lp_lanes];  ///< of a ball about the centroid around the child
  /// The integral of |y - centroid|^n over the child is at most this, n the first order left out.
  double remainder[k_lp_lanes];
};

/// Four triangles. Empty lanes have no area.
struct LpTriangleBlock {
  double corners[3][3][k_lp_lanes];  ///< corner, coordinate
  double normal[3][k_lp_lanes];
  double twice_area[k_lp_lanes];
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
  std::vector<LpTriangleBlock> blocks;
  std::vector<double> block_masses;  ///< four for each block
};

}  // namespace recede::detail
