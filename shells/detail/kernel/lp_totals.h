// Sums over leaves of triangles, and weights within a support.
#pragma once

#include <recede/shells/detail/kernel/cubic_triangle.h>
#include <recede/shells/detail/lp_kernel.h>

namespace recede::detail {
namespace {

/// 1 up to the support, 0 from 5/4 of it on.
inline Double4 weight_of(Double4 distance, double support) {
  const Double4 t = (all4(k_lp_fade_end * support) - distance) * all4(1 / ((k_lp_fade_end - 1) * support));
  const Double4 zero = all4(0), one = all4(1);
  const Double4 inside = select(t < zero, zero, select(t > one, one, t));
  return inside * inside * (all4(3) - all4(2) * inside);
}

inline Vector4 vectors_at(const double (&values)[3][4]) {
  return {lanes_at(values[0]), lanes_at(values[1]), lanes_at(values[2])};
}

/// Of the triangles of leaves, four at a time, for p = 3.
struct LeafTotals {
  Double4 value = all4(0), mass = all4(0);
  Vector4 gradient = {all4(0), all4(0), all4(0)};

  template <bool is_weighted>
  void add(const Vector4& x, double support, const LpBlock& block) {
    const Vector4 a = vectors_at(block.corners[0]) - x, b = vectors_at(block.corners[1]) - x,
                  c = vectors_at(block.corners[2]) - x;
    IntegralLanes<Double4> part =
        integrate_cubic<FourLanes>(a, b, c, vectors_at(block.normal), lanes_at(block.twice_area));
    Double4 area = lanes_at(block.mass);
    if constexpr (is_weighted) {
      const Double4 third = all4(1.0 / 3);
      const Vector4 centroid = {(a.x + b.x + c.x) * third, (a.y + b.y + c.y) * third,
                                (a.z + b.z + c.z) * third};
      const Vector4 to_a = a - centroid, to_b = b - centroid, to_c = c - centroid;
      const Double4 radius = root(larger(dot(to_a, to_a), larger(dot(to_b, to_b), dot(to_c, to_c))));
      const Double4 excess = larger(radius - all4(k_lp_large_triangle * support), all4(0));
      const Double4 weight = weight_of(root(dot(centroid, centroid)) - excess, support);
      // A triangle that doesn't count may be anywhere, but not the reason for an infinity.
      const Mask4 counts = weight > all4(0);
      part.value = where(counts, part.value * weight);
      part.gradient = {where(counts, part.gradient.x * weight), where(counts, part.gradient.y * weight),
                       where(counts, part.gradient.z * weight)};
      area *= weight;
    }
    value += part.value;
    gradient.x += part.gradient.x;
    gradient.y += part.gradient.y;
    gradient.z += part.gradient.z;
    mass += area;
  }
};

}  // namespace
}  // namespace recede::detail
