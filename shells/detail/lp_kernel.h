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

/// Squared distances from a child's centroid that decide within a support.
struct LpFade {
  double squared_full[k_lp_lanes];   ///< below this all of the child has the weight 1
  double squared_end[k_lp_lanes];    ///< above this all of it has the weight 0
  double squared_limit[k_lp_lanes];  ///< from here on it isn't summed up, as its weights differ too much
};

/// Four triangles, or points as their first corners. Empty lanes have neither area nor mass.
struct LpBlock {
  double corners[3][3][k_lp_lanes];  ///< corner, coordinate
  double normal[3][k_lp_lanes];
  double twice_area[k_lp_lanes];
  double mass[k_lp_lanes];
};

inline constexpr double k_lp_fade_end = 1.25;  ///< of the support
/// Where weights differ, the largest radius of a part that is summed up, of the support.
inline constexpr double k_lp_fading_part = 0.3;
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

/// A node that is to be visited, and four lanes for each point that looks into it, as bits.
struct LpVisit {
  std::uint32_t node, lanes;
};
/// Visits are written before it's known whether they count.
inline constexpr std::size_t k_lp_visits_ahead = 4;

struct LpKernel {
  LpSums (*sum)(const LpArrays& arrays, const LpQuery& query);
  /// Of triangles for p = 3 and a finite support without bounds, at `n` points that had best be near to each
  /// other. A point's sums don't depend on the others.
  void (*sum_packet)(const LpArrays& arrays, const LpFade* fades, const LpQuery* queries, int n,
                     LpSums* sums);
  /// Of triangles for p = 3 without support and bounds, but for the area, which is all. Each point had best
  /// be near to the next; its sums don't depend on the others. `visits` has room for all nodes and
  /// `k_lp_visits_ahead`.
  void (*sum_each)(const LpArrays& arrays, const LpQuery* queries, int n, LpVisit* visits, LpSums* sums);
};

/// The version for this processor. All have the same results.
const LpKernel& lp_kernel();
extern const LpKernel k_lp_kernel_baseline;
extern const LpKernel k_lp_kernel_avx2;    ///< for x86-64 only
extern const LpKernel k_lp_kernel_avx512;  ///< as well

}  // namespace recede::detail
