// Sums over a tree of parts of a surface. Plain data and functions only: the sources behind it are compiled
// once for each kind of processor, and may share no inline code with others.
#pragma once

#include <cstddef>
#include <cstdint>

namespace recede::detail {

inline constexpr std::size_t k_lp_lanes = 4;  ///< children of a node, elements of a leaf
inline constexpr std::uint32_t k_lp_leaf_bit = 0x80000000u;

/// Four children side by side: one visit reads one place in memory, and the four are summed up at once.
/// Lanes without a child have no mass, and count as far.
struct LpNode {
  double center[3][k_lp_lanes];      ///< centroids
  double squared_reach[k_lp_lanes];  ///< the child may be summed up where it's farther than this
  double mass[k_lp_lanes];
  /// With r the vector from the centroid: what the child adds to I_p is
  /// |r|^-p (mass + |r|^-4 r.(tensor r)); xx, yy, zz, xy, xz, yz.
  double tensor[6][k_lp_lanes];
  std::uint32_t child[k_lp_lanes];  ///< a node, or leaf bit and block
};

/// What only bounds and supports ask for.
struct LpNodeExtent {
  double radius[k_lp_lanes];  ///< of a ball about the centroid around the child
  /// The integral of |y - centroid|^n over the child is at most this, n the first order left out.
  double remainder[k_lp_lanes];
};

/// Four triangles, or points as their first corners. Empty lanes have neither area nor mass.
struct LpBlock {
  double corners[3][3][k_lp_lanes];  ///< corner, coordinate
  double normal[3][k_lp_lanes];
  double twice_area[k_lp_lanes];
  double mass[k_lp_lanes];
};

inline constexpr double k_lp_fade_end = 1.25;  ///< of the support
/// Of the support: by how much a triangle's radius exceeds this, by so much it counts as nearer. Else all of
/// a surface of large triangles would be out of sight of a point on it.
inline constexpr double k_lp_large_triangle = 0.125;

/// Where, and how.
struct LpQuery {
  double point[3];
  double p;
  double unit;     ///< powers p of lengths are relative to it
  double support;  ///< may be infinite
  bool is_bounded;
  int first_order_left_out;
};

struct LpSums {
  double integral = 0;  ///< I_p
  double gradient[3] = {0, 0, 0};
  double area = 0;            ///< that was integrated, by weights
  double error = 0;           ///< of the integral, at most
  double gradient_error = 0;  ///< at most
};

struct LpArrays {
  const LpNode* nodes;  ///< the root first
  const LpNodeExtent* extents;
  const LpBlock* blocks;
  /// Adds a leaf; nothing: triangles for p = 3, which the kernel knows.
  void (*add_leaf)(const LpBlock& block, const LpQuery& query, LpSums& sums);
};

struct LpKernel {
  LpSums (*sum)(const LpArrays& arrays, const LpQuery& query);
};

/// The version for this processor. All have the same results.
const LpKernel& lp_kernel();
extern const LpKernel k_lp_kernel_baseline;
extern const LpKernel k_lp_kernel_avx2;  ///< for x86-64 only

}  // namespace recede::detail
