// The integral of |y|^-3 over triangles and its gradient, by edges, four triangles at a time.
#pragma once

#include <recede/shells/detail/kernel/double_lanes.h>

namespace recede::detail {
namespace {

struct Integral4 {
  Double4 value;
  Vector4 gradient;  ///< by the point of interest, which is the origin
};

/// (atan(t) / t - 1) / t^2 for 0 <= t^2 <= tan(pi / 8)^2, of `z` = t^2: a polynomial through Chebyshev's
/// points.
inline Double4 arc_tangent_tail(Double4 z) {
  constexpr double k_coefficients[] = {-0.3333333333333333,  0.19999999999995516,  -0.14285714284665682,
                                       0.11111111015187018,  -0.0909090457530649,  0.07692183125376892,
                                       -0.06664510525508936, 0.05858140904866328,  -0.050854078345894844,
                                       0.03923044778479309,  -0.019175404711104935};
  Double4 result = all4(k_coefficients[10]);
  for (int k = 9; k >= 0; --k) result = result * z + all4(k_coefficients[k]);
  return result;
}

/// For an edge from a to b, |a| |b| + a.b: by the cross product where the edge is seen under an obtuse angle,
/// as the sum would cancel.
inline Double4 edge_term(const Vector4& a, const Vector4& b, Double4 lengths, Double4 dot_ab) {
  const Mask4 is_obtuse = dot_ab < all4(0);
  if (bits_of(is_obtuse) == 0) return lengths + dot_ab;
  const Vector4 normal = cross(a, b);
  return select(is_obtuse, dot(normal, normal) / (lengths - dot_ab), lengths + dot_ab);
}

/// Triangles by their corners relative to the point of interest, their unit normals (those of a
/// counter-clockwise triangle) and twice their areas. Where the area is zero, so is the result. On a triangle
/// the value is infinite or not a number.
///
/// With w the height over the plane and Omega the solid angle, I = Omega / |w|, and the gradient is the sum
/// over edges of the edge's outward normal times the integral of |y|^-3 along it, and a normal part that is
/// the derivative of Omega / |w| by w. Near the plane, outside of the triangle, both follow from tan(Omega /
/// 2) = N / D with N = 2 area |w|, without a division by w. The integral along an edge is |b - a| (1 / |a| +
/// 1 / |b|) / (|a| |b| + a.b).
RECEDE_INLINE Integral4 integrate_cubic(const Vector4& a, const Vector4& b, const Vector4& c,
                                        const Vector4& normal, Double4 twice_area) {
  const Double4 zero = all4(0), one = all4(1), two = all4(2);
  const Double4 ra = root(dot(a, a)), rb = root(dot(b, b)), rc = root(dot(c, c));
  const Double4 ia = one / ra, ib = one / rb, ic = one / rc;
  const Double4 ab = dot(a, b), bc = dot(b, c), ca = dot(c, a);
  const Double4 eab = edge_term(a, b, ra * rb, ab), ebc = edge_term(b, c, rb * rc, bc),
                eca = edge_term(c, a, rc * ra, ca);
  const Double4 w = -dot(a, normal), height = magnitude(w);
  const Double4 numerator = twice_area * height;
  const Double4 denominator = ra * rb * rc + ab * rc + bc * ra + ca * rb;
  // The derivative of the denominator by w, over w.
  const Double4 slope = ebc * ia + eca * ib + eab * ic + two * (ra + rb + rc);

  // Omega / 2 = base + atan(t), |t| <= tan(pi / 8).
  constexpr double k_tangent = 0.4142135623730950, k_half_pi = 1.5707963267948966;
  const Double4 size = magnitude(denominator);
  const Mask4 is_ahead = denominator > zero;
  const Mask4 is_flat = numerator <= all4(k_tangent) * size, is_steep = size <= all4(k_tangent) * numerator;
  const Double4 up = select(is_flat, numerator, select(is_steep, -denominator, numerator - size)),
                along = select(is_flat, size, select(is_steep, numerator, numerator + size));
  const Mask4 is_small = is_flat & is_ahead;
  const Double4 t = up / along, z = t * t, tail = arc_tangent_tail(z);
  // Of atan2(numerator, size), mirrored for what lies behind; the steep case has its sign already.
  const Double4 angle = t * (one + z * tail);
  const Double4 mirrored = select(is_ahead, angle, -angle);
  const Double4 base = select(is_flat, select(is_ahead, zero, all4(2 * k_half_pi)),
                              select(is_ahead, all4(0.5 * k_half_pi), all4(1.5 * k_half_pi)));
  const Double4 half_angle = select(is_steep, all4(k_half_pi) + angle, base + mirrored);

  const Double4 inverse = one / select(is_small, denominator, w);
  const Double4 small_ratio = twice_area * inverse;
  const Double4 value =
      select(is_small, two * small_ratio * (one + z * tail), two * half_angle * magnitude(inverse));
  const Double4 secant = one / (one + z);
  const Double4 by_height_small =
      two * small_ratio * w * (-slope * inverse * secant - small_ratio * small_ratio * (secant + tail));
  // Each edge's term is the product of the other two over that of all three.
  const Double4 eab_ebc = eab * ebc, around_all = one / (eab_ebc * eca);
  const Double4 angle_slope = twice_area * (denominator - w * w * slope) * around_all;  // of Omega by |w|
  const Double4 by_height = select(is_small, by_height_small, (angle_slope - value) * inverse);

  const Double4 lab = (ia + ib) * (ebc * eca * around_all), lbc = (ib + ic) * (eab * eca * around_all),
                lca = (ic + ia) * (eab_ebc * around_all);
  const Vector4 around = {(b.x - a.x) * lab + (c.x - b.x) * lbc + (a.x - c.x) * lca,
                          (b.y - a.y) * lab + (c.y - b.y) * lbc + (a.y - c.y) * lca,
                          (b.z - a.z) * lab + (c.z - b.z) * lbc + (a.z - c.z) * lca};
  const Vector4 inward = cross(normal, around);
  const Mask4 counts = twice_area > zero;
  return {where(counts, value),
          {where(counts, inward.x + by_height * normal.x), where(counts, inward.y + by_height * normal.y),
           where(counts, inward.z + by_height * normal.z)}};
}

}  // namespace
}  // namespace recede::detail
