// Four doubles at once, for the sources that are compiled once for each kind of processor; where registers
// hold two, the compiler takes them in turn. Results are the same to the last bit. Everything here has
// internal linkage, so that no version of it is called by sources compiled for older processors.
#pragma once

#if defined(__AVX512F__)
#include <immintrin.h>
#endif

// For what a query does many times: calls would pass lanes through memory.
#define RECEDE_INLINE inline __attribute__((always_inline))

namespace recede::detail {
namespace {

using Double4 = double __attribute__((vector_size(32)));
using Mask4 = long long __attribute__((vector_size(32)));

inline Double4 all4(double value) { return Double4{value, value, value, value}; }

inline Double4 lanes_at(const double (&values)[4]) {
  Double4 lanes;
  __builtin_memcpy(&lanes, values, sizeof lanes);
  return lanes;
}

inline Double4 select(Mask4 mask, Double4 yes, Double4 no) {
  return reinterpret_cast<Double4>((mask & reinterpret_cast<Mask4>(yes)) |
                                   (~mask & reinterpret_cast<Mask4>(no)));
}

inline Double4 larger(Double4 a, Double4 b) { return select(a > b, a, b); }

/// The value, or zero whatever the value is, infinite ones too.
inline Double4 where(Mask4 mask, Double4 value) {
  return reinterpret_cast<Double4>(mask & reinterpret_cast<Mask4>(value));
}

/// A bit for each lane of a comparison.
inline unsigned bits_of(Mask4 mask) {
#if defined(__AVX__)
  return static_cast<unsigned>(__builtin_ia32_movmskpd256(reinterpret_cast<Double4>(mask)));
#else
  return static_cast<unsigned>((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
#endif
}

inline Double4 root(Double4 x) {
  return Double4{__builtin_sqrt(x[0]), __builtin_sqrt(x[1]), __builtin_sqrt(x[2]), __builtin_sqrt(x[3])};
}

inline Double4 magnitude(Double4 x) {
  constexpr long long k_rest = 0x7fffffffffffffff;
  return reinterpret_cast<Double4>(reinterpret_cast<Mask4>(x) & Mask4{k_rest, k_rest, k_rest, k_rest});
}

inline double total(Double4 x) { return (x[0] + x[1]) + (x[2] + x[3]); }

/// Three coordinates of vectors, one in each lane.
template <typename Double>
struct VectorLanes {
  Double x, y, z;
};
using Vector4 = VectorLanes<Double4>;

template <typename Double>
inline VectorLanes<Double> operator-(const VectorLanes<Double>& a, const VectorLanes<Double>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <typename Double>
inline Double dot(const VectorLanes<Double>& a, const VectorLanes<Double>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <typename Double>
inline VectorLanes<Double> cross(const VectorLanes<Double>& a, const VectorLanes<Double>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// As many lanes as the processor has: numbers, and a bit for each lane where something holds.
struct FourLanes {
  using Double = Double4;
  using Mask = Mask4;
  using Bits = unsigned long long __attribute__((vector_size(32)));
  static constexpr int k_size = 4;
  static Double repeated(const double (&values)[4]) { return lanes_at(values); }  ///< in each four lanes
  static Mask is_less(Double a, Double b) { return a < b; }
  static Mask is_at_most(Double a, Double b) { return a <= b; }
  static Mask both(Mask a, Mask b) { return a & b; }
  static Mask mask_of(unsigned bits) {
    const Mask4 all = {bits, bits, bits, bits};
    return (all & Mask4{1, 2, 4, 8}) != Mask4{0, 0, 0, 0};
  }
  static unsigned bits(Mask mask) { return bits_of(mask); }
  static Double choose(Mask mask, Double yes, Double no) { return select(mask, yes, no); }
  static Double where_true(Mask mask, Double value) { return where(mask, value); }
  static Double absolute(Double x) { return magnitude(x); }
  static Double all(double value) { return all4(value); }
  static unsigned less(Double a, Double b) { return bits_of(a < b); }
  static unsigned at_most(Double a, Double b) { return bits_of(a <= b); }
  static Double square_root(Double x) { return root(x); }
  static Double larger_of(Double a, Double b) { return larger(a, b); }
  static Double smaller_of(Double a, Double b) { return select(a < b, a, b); }
  static Double where_set(unsigned bits, Double value) { return where(mask_of(bits), value); }
};

#if defined(__AVX512F__)
struct EightLanes {
  using Double = double __attribute__((vector_size(64)));
  using Mask = __mmask8;
  using Bits = unsigned long long __attribute__((vector_size(64)));
  static constexpr int k_size = 8;
  static Double repeated(const double (&values)[4]) {
    return _mm512_maskz_broadcast_f64x4(0xff, lanes_at(values));  // at memory: no shuffle
  }
  static Mask is_less(Double a, Double b) { return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ); }
  static Mask is_at_most(Double a, Double b) { return _mm512_cmp_pd_mask(a, b, _CMP_LE_OQ); }
  static Mask both(Mask a, Mask b) { return static_cast<Mask>(a & b); }
  static Mask mask_of(unsigned bits) { return static_cast<Mask>(bits); }
  static unsigned bits(Mask mask) { return mask; }
  static Double choose(Mask mask, Double yes, Double no) { return _mm512_mask_blend_pd(mask, no, yes); }
  static Double where_true(Mask mask, Double value) { return _mm512_maskz_mov_pd(mask, value); }
  static Double absolute(Double x) { return _mm512_abs_pd(x); }
  static Double all(double value) { return _mm512_set1_pd(value); }
  static unsigned less(Double a, Double b) { return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ); }
  static unsigned at_most(Double a, Double b) { return _mm512_cmp_pd_mask(a, b, _CMP_LE_OQ); }
  static Double square_root(Double x) { return _mm512_sqrt_pd(x); }
  static Double larger_of(Double a, Double b) { return _mm512_max_pd(a, b); }
  static Double smaller_of(Double a, Double b) { return _mm512_min_pd(a, b); }
  static Double where_set(unsigned bits, Double value) {
    return _mm512_maskz_mov_pd(static_cast<__mmask8>(bits), value);
  }
};
using WidestLanes = EightLanes;
#else
using WidestLanes = FourLanes;
#endif

/// 1 / sqrt(x) of `n` times as many numbers, within two units in the last place; normal ones. Half the
/// exponent and a first guess of the digits (by 3.5 % at most) by the representation, and four steps of
/// Newton's: processors take longer for a root and a division. They are side by side, as each step waits
/// for the one before.
template <typename Lanes, int n>
RECEDE_INLINE void reciprocal_roots(const typename Lanes::Double (&x)[n], typename Lanes::Double (&y)[n]) {
  using Double = typename Lanes::Double;
  using Bits = typename Lanes::Bits;
  constexpr unsigned long long k_middle = 0x5fe6eb50c7b537a9;
  Double half[n];
  for (int i = 0; i < n; ++i) {
    y[i] = reinterpret_cast<Double>(k_middle - (reinterpret_cast<Bits>(x[i]) >> 1));
    half[i] = Lanes::all(0.5) * x[i];
  }
#pragma GCC unroll 4
  for (int step = 0; step < 4; ++step) {
    Double change[n];
    for (int i = 0; i < n; ++i) change[i] = y[i] * y[i];
    for (int i = 0; i < n; ++i) change[i] = half[i] * change[i];
    for (int i = 0; i < n; ++i) change[i] = Lanes::all(1.5) - change[i];
    for (int i = 0; i < n; ++i) y[i] = y[i] * change[i];
  }
}

}  // namespace
}  // namespace recede::detail
