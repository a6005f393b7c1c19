// The integral of |y|^-3 over triangles and its gradient, by edges, two triangles at a time.
#pragma once

#include <recede/shells/detail/double_pair.h>

namespace recede::detail {

struct IntegralPair {
  DoublePair value;
  Vec3Pair gradient;  ///< by the point of interest, which is the origin
};

/// (atan(t) / t - 1) / t^2 for 0 <= t^2 <= tan(pi / 8)^2, of `z` = t^2: a polynomial through Chebyshev's
/// points.
inline DoublePair arc_tangent_tail(DoublePair z) {
  constexpr double k_coefficients[] = {-0.3333333333333333,  0.19999999999995516,  -0.14285714284665682,
                                       0.11111111015187018,  -0.0909090457530649,  0.07692183125376892,
                                       -0.06664510525508936, 0.05858140904866328,  -0.050854078345894844,
                                       0.03923044778479309,  -0.019175404711104935};
  DoublePair result = both(k_coefficients[10]);
  for (int k = 9; k >= 0; --k) result = result * z + both(k_coefficients[k]);
  return result;
}

/// For an edge from a to b, |a| |b| + a.b: by the cross product where the edge is seen under an obtuse angle,
/// as the sum would cancel.
inline DoublePair edge_term(const Vec3Pair& a, const Vec3Pair& b, DoublePair lengths, DoublePair dot_ab) {
  const Vec3Pair normal = cross(a, b);
  const PairMask is_obtuse = dot_ab < both(0);
  const DoublePair stable = dot(normal, normal) / (lengths - dot_ab);
  return select(is_obtuse, stable, lengths + dot_ab);
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
inline IntegralPair integrate_cubic(const Vec3Pair& a, const Vec3Pair& b, const Vec3Pair& c,
                                    const Vec3Pair& normal, DoublePair twice_area) {
  const DoublePair zero = both(0), one = both(1), two = both(2);
  const DoublePair ra = root(dot(a, a)), rb = root(dot(b, b)), rc = root(dot(c, c));
  const DoublePair ia = one / ra, ib = one / rb, ic = one / rc;
  const DoublePair ab = dot(a, b), bc = dot(b, c), ca = dot(c, a);
  const DoublePair eab = edge_term(a, b, ra * rb, ab), ebc = edge_term(b, c, rb * rc, bc),
                   eca = edge_term(c, a, rc * ra, ca);
  const DoublePair w = -dot(a, normal), height = magnitude(w);
  const DoublePair numerator = twice_area * height;
  const DoublePair denominator = ra * rb * rc + ab * rc + bc * ra + ca * rb;
  // The derivative of the denominator by w, over w.
  const DoublePair slope = ebc * ia + eca * ib + eab * ic + two * (ra + rb + rc);

  // Omega / 2 = base + atan(t), |t| <= tan(pi / 8).
  constexpr double k_tangent = 0.4142135623730950, k_half_pi = 1.5707963267948966;
  const DoublePair size = magnitude(denominator);
  const PairMask is_ahead = denominator > zero;
  const PairMask is_flat = numerator <= both(k_tangent) * size,
                 is_steep = size <= both(k_tangent) * numerator;
  const DoublePair up = select(is_flat, numerator, select(is_steep, -denominator, numerator - size)),
                   along = select(is_flat, size, select(is_steep, numerator, numerator + size));
  const PairMask is_small = is_flat & is_ahead;
  const DoublePair t = up / along, z = t * t, tail = arc_tangent_tail(z);
  // Of atan2(numerator, size), mirrored for what lies behind; the steep case has its sign already.
  const DoublePair angle = t * (one + z * tail);
  const DoublePair mirrored = select(is_ahead, angle, -angle);
  const DoublePair base = select(is_flat, select(is_ahead, zero, both(2 * k_half_pi)),
                                 select(is_ahead, both(0.5 * k_half_pi), both(1.5 * k_half_pi)));
  const DoublePair half_angle = select(is_steep, both(k_half_pi) + angle, base + mirrored);

  const DoublePair inverse = one / select(is_small, denominator, w);
  const DoublePair small_ratio = twice_area * inverse;
  const DoublePair value =
      select(is_small, two * small_ratio * (one + z * tail), two * half_angle * magnitude(inverse));
  const DoublePair by_height_small =
      two * small_ratio * w *
      (-slope * inverse / (one + z) - small_ratio * small_ratio * (one / (one + z) + tail));
  const DoublePair angle_slope =
      twice_area * (denominator - w * w * slope) / (eab * ebc * eca);  // of Omega by |w|
  const DoublePair by_height = select(is_small, by_height_small, (angle_slope - value) * inverse);

  const DoublePair lab = (ia + ib) / eab, lbc = (ib + ic) / ebc, lca = (ic + ia) / eca;
  const Vec3Pair around = {(b.x - a.x) * lab + (c.x - b.x) * lbc + (a.x - c.x) * lca,
                           (b.y - a.y) * lab + (c.y - b.y) * lbc + (a.y - c.y) * lca,
                           (b.z - a.z) * lab + (c.z - b.z) * lbc + (a.z - c.z) * lca};
  const Vec3Pair inward = cross(normal, around);
  const PairMask counts = twice_area > zero;
  return {where(counts, value),
          {where(counts, inward.x + by_height * normal.x), where(counts, inward.y + by_height * normal.y),
           where(counts, inward.z + by_height * normal.z)}};
}

}  // namespace recede::detail
