// Four and eight floats at once, for the sources that are compiled once for each kind of processor.
// Everything here has internal linkage, so that no version of it is called by sources compiled for older
// processors.
#pragma once

#include <cstdint>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

// For functions on the way of every ray: calls would pass lanes through memory.
#define RECEDE_INLINE inline __attribute__((always_inline))

namespace recede::detail {
namespace {

using Float4 = float __attribute__((vector_size(16)));
using Float8 = float __attribute__((vector_size(32)));
using Int4 = int __attribute__((vector_size(16)));
using UInt4 = unsigned __attribute__((vector_size(16)));
using Int8 = int __attribute__((vector_size(32)));

inline Float4 all4(float value) { return Float4{value, value, value, value}; }
inline Float8 all8(float value) { return Float8{value, value, value, value, value, value, value, value}; }
inline Float4 lower_half(Float8 a) { return __builtin_shufflevector(a, a, 0, 1, 2, 3); }
inline Float4 upper_half(Float8 a) { return __builtin_shufflevector(a, a, 4, 5, 6, 7); }
inline Float8 join(Float4 lower, Float4 upper) {
  return __builtin_shufflevector(lower, upper, 0, 1, 2, 3, 4, 5, 6, 7);
}

#if defined(__SSE2__)
inline Float4 least(Float4 a, Float4 b) { return _mm_min_ps(a, b); }
inline Float4 largest(Float4 a, Float4 b) { return _mm_max_ps(a, b); }
inline unsigned sign_bits(Int4 a) { return static_cast<unsigned>(_mm_movemask_ps((__m128)a)); }
inline Int4 truncated(Float4 a) { return (Int4)_mm_cvttps_epi32(a); }
inline Float4 to_floats(Int4 a) { return _mm_cvtepi32_ps((__m128i)a); }
/// 1 / sqrt(a) within a share of 4e-4, for positive a.
inline Float4 rough_inverse_root(Float4 a) { return _mm_rsqrt_ps(a); }
#else
inline Float4 least(Float4 a, Float4 b) { return a < b ? a : b; }
inline Float4 largest(Float4 a, Float4 b) { return a > b ? a : b; }
inline unsigned sign_bits(Int4 a) {
  return (a[0] < 0 ? 1u : 0u) | (a[1] < 0 ? 2u : 0u) | (a[2] < 0 ? 4u : 0u) | (a[3] < 0 ? 8u : 0u);
}
inline Int4 truncated(Float4 a) { return __builtin_convertvector(a, Int4); }
inline Float4 to_floats(Int4 a) { return __builtin_convertvector(a, Float4); }
inline Float4 rough_inverse_root(Float4 a) {
  Float4 root;
  for (int k = 0; k < 4; ++k) root[k] = 1 / __builtin_sqrtf(a[k]);
  return root;
}
#endif

#if defined(__AVX2__)
inline Float8 least(Float8 a, Float8 b) { return _mm256_min_ps(a, b); }
inline Float8 largest(Float8 a, Float8 b) { return _mm256_max_ps(a, b); }
inline unsigned sign_bits(Int8 a) { return static_cast<unsigned>(_mm256_movemask_ps((__m256)a)); }
inline Int8 truncated(Float8 a) { return (Int8)_mm256_cvttps_epi32(a); }
inline Float8 to_floats(Int8 a) { return _mm256_cvtepi32_ps((__m256i)a); }
inline Float8 square_root(Float8 a) { return _mm256_sqrt_ps(a); }
#else
inline Float8 least(Float8 a, Float8 b) {
  return join(least(lower_half(a), lower_half(b)), least(upper_half(a), upper_half(b)));
}
inline Float8 largest(Float8 a, Float8 b) {
  return join(largest(lower_half(a), lower_half(b)), largest(upper_half(a), upper_half(b)));
}
inline unsigned sign_bits(Int8 a) {
  return sign_bits(__builtin_shufflevector(a, a, 0, 1, 2, 3)) |
         sign_bits(__builtin_shufflevector(a, a, 4, 5, 6, 7)) << 4;
}
inline Int8 truncated(Float8 a) { return __builtin_convertvector(a, Int8); }
inline Float8 to_floats(Int8 a) { return __builtin_convertvector(a, Float8); }
inline Float8 square_root(Float8 a) {
  Float8 root;
  for (int k = 0; k < 8; ++k) root[k] = __builtin_sqrtf(a[k]);
  return root;
}
#endif

inline int any_bits(Int4 a) {
  a |= __builtin_shufflevector(a, a, 2, 3, 0, 1);
  a |= __builtin_shufflevector(a, a, 1, 0, 3, 2);
  return a[0];
}
inline bool is_any(Int4 a) { return sign_bits(a != 0) != 0; }

inline float least_lane(Float8 a) {
  Float4 b = least(lower_half(a), upper_half(a));
  b = least(b, __builtin_shufflevector(b, b, 2, 3, 0, 1));
  b = least(b, __builtin_shufflevector(b, b, 1, 0, 3, 2));
  return b[0];
}

/// Rows become columns.
inline void transpose(Float4& a, Float4& b, Float4& c, Float4& d) {
  const Float4 ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5);
  const Float4 ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const Float4 cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5);
  const Float4 cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
  a = __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5);
  b = __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7);
  c = __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5);
  d = __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7);
}

// In either half.
inline void transpose(Float8& a, Float8& b, Float8& c, Float8& d) {
  const Float8 ab_low = __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
  const Float8 ab_high = __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
  const Float8 cd_low = __builtin_shufflevector(c, d, 0, 8, 1, 9, 4, 12, 5, 13);
  const Float8 cd_high = __builtin_shufflevector(c, d, 2, 10, 3, 11, 6, 14, 7, 15);
  a = __builtin_shufflevector(ab_low, cd_low, 0, 1, 8, 9, 4, 5, 12, 13);
  b = __builtin_shufflevector(ab_low, cd_low, 2, 3, 10, 11, 6, 7, 14, 15);
  c = __builtin_shufflevector(ab_high, cd_high, 0, 1, 8, 9, 4, 5, 12, 13);
  d = __builtin_shufflevector(ab_high, cd_high, 2, 3, 10, 11, 6, 7, 14, 15);
}

}  // namespace
}  // namespace recede::detail
