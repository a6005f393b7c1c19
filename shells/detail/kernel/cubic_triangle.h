// The integral of |y|^-3 over triangles and its gradient, by edges, a triangle in each lane.
#pragma once

#include <recede/shells/detail/kernel/double_lanes.h>

namespace recede::detail {
namespace {

template <typename Double>
struct IntegralLanes {
  Double value;
  VectorLanes<Double> gradient;  ///< by the point of interest, which is the origin
};

/// (atan(t) / t - 1) / t^2 for 0 <= t^2 <= tan(pi / 8)^2, of `z` = t^2: a polynomial through Chebyshev's
/// points.
template <typename Lanes>
inline typename Lanes::Double arc_tangent_tail(typename Lanes::Double z) {
  constexpr double k_coefficients[] = {-0.3333333333333333,  0.19999999999995516,  -0.14285714284665682,
                                       0.11111111015187018,  -0.0909090457530649,  0.07692183125376892,
                                       -0.06664510525508936, 0.05858140904866328,  -0.050854078345894844,
                                       0.03923044778479309,  -0.019175404711104935};
  typename Lanes::Double result = Lanes::all(k_coefficients[10]);
  for (int k = 9; k >= 0; --k) result = result * z + Lanes::all(k_coefficients[k]);
  return result;
}

/// For an edge from a to b, |a| |b| + a.b: by the cross product where the edge is seen under an obtuse angle,
/// as the sum would cancel.
template <typename Lanes, typename Double>
inline Double edge_term(const VectorLanes<Double>& a, const VectorLanes<Double>& b, Double lengths,
                        Double dot_ab) {
  const auto is_obtuse = Lanes::is_less(dot_ab, Lanes::all(0));
  if (Lanes::bits(is_obtuse) == 0) return lengths + dot_ab;
  const VectorLanes<Double> normal = cross(a, b);
  return Lanes::choose(is_obtuse, dot(normal, normal) / (lengths - dot_ab), lengths + dot_ab);
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
template <typename Lanes, typename Double>
RECEDE_INLINE IntegralLanes<Double> integrate_cubic(const VectorLanes<Double>& a,
                                                    const VectorLanes<Double>& b,
                                                    const VectorLanes<Double>& c,
                                                    const VectorLanes<Double>& normal, Double twice_area) {
  using Mask = typename Lanes::Mask;
  const auto all = [](double number) { return Lanes::all(number); };
  const auto choose = [](Mask mask, Double yes, Double no) { return Lanes::choose(mask, yes, no); };
  const Double zero = all(0), one = all(1), two = all(2);
  const Double ra = Lanes::square_root(dot(a, a)), rb = Lanes::square_root(dot(b, b)),
               rc = Lanes::square_root(dot(c, c));
  const Double ia = one / ra, ib = one / rb, ic = one / rc;
  const Double ab = dot(a, b), bc = dot(b, c), ca = dot(c, a);
  const Double eab = edge_term<Lanes>(a, b, ra * rb, ab), ebc = edge_term<Lanes>(b, c, rb * rc, bc),
               eca = edge_term<Lanes>(c, a, rc * ra, ca);
  const Double w = -dot(a, normal), height = Lanes::absolute(w);
  const Double numerator = twice_area * height;
  const Double denominator = ra * rb * rc + ab * rc + bc * ra + ca * rb;
  // The derivative of the denominator by w, over w.
  const Double slope = ebc * ia + eca * ib + eab * ic + two * (ra + rb + rc);

  // Omega / 2 = base + atan(t), |t| <= tan(pi / 8).
  constexpr double k_tangent = 0.4142135623730950, k_half_pi = 1.5707963267948966;
  const Double size = Lanes::absolute(denominator);
  const Mask is_ahead = Lanes::is_less(zero, denominator);
  const Mask is_flat = Lanes::is_at_most(numerator, all(k_tangent) * size),
             is_steep = Lanes::is_at_most(size, all(k_tangent) * numerator);
  const Double up = choose(is_flat, numerator, choose(is_steep, -denominator, numerator - size)),
               along = choose(is_flat, size, choose(is_steep, numerator, numerator + size));
  const Mask is_small = Lanes::both(is_flat, is_ahead);
  const Double t = up / along, z = t * t, tail = arc_tangent_tail<Lanes>(z);
  // Of atan2(numerator, size), mirrored for what lies behind; the steep case has its sign already.
  const Double angle = t * (one + z * tail);
  const Double mirrored = choose(is_ahead, angle, -angle);
  const Double base = choose(is_flat, choose(is_ahead, zero, all(2 * k_half_pi)),
                             choose(is_ahead, all(0.5 * k_half_pi), all(1.5 * k_half_pi)));
  const Double half_angle = choose(is_steep, all(k_half_pi) + angle, base + mirrored);

  const Double inverse = one / choose(is_small, denominator, w);
  const Double small_ratio = twice_area * inverse;
  const Double value =
      choose(is_small, two * small_ratio * (one + z * tail), two * half_angle * Lanes::absolute(inverse));
  const Double secant = one / (one + z);
  const Double by_height_small =
      two * small_ratio * w * (-slope * inverse * secant - small_ratio * small_ratio * (secant + tail));
  // Each edge's term is the product of the other two over that of all three.
  const Double eab_ebc = eab * ebc, around_all = one / (eab_ebc * eca);
  const Double angle_slope = twice_area * (denominator - w * w * slope) * around_all;  // of Omega by |w|
  const Double by_height = choose(is_small, by_height_small, (angle_slope - value) * inverse);

  const Double lab = (ia + ib) * (ebc * eca * around_all), lbc = (ib + ic) * (eab * eca * around_all),
               lca = (ic + ia) * (eab_ebc * around_all);
  const VectorLanes<Double> around = {(b.x - a.x) * lab + (c.x - b.x) * lbc + (a.x - c.x) * lca,
                                      (b.y - a.y) * lab + (c.y - b.y) * lbc + (a.y - c.y) * lca,
                                      (b.z - a.z) * lab + (c.z - b.z) * lbc + (a.z - c.z) * lca};
  const VectorLanes<Double> inward = cross(normal, around);
  const Mask counts = Lanes::is_less(zero, twice_area);
  return {Lanes::where_true(counts, value),
          {Lanes::where_true(counts, inward.x + by_height * normal.x),
           Lanes::where_true(counts, inward.y + by_height * normal.y),
           Lanes::where_true(counts, inward.z + by_height * normal.z)}};
}

}  // namespace
}  // namespace recede::detail
