// Denormal numbers cost Embree's traversal dearly and change no picture.
#pragma once

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace recede::detail {

/// While it lives, the thread treats denormal floating-point numbers as zero (FTZ and DAZ).
class FlushDenormals {
 public:
#if defined(__SSE__)
  FlushDenormals() : before_(_mm_getcsr()) { _mm_setcsr(before_ | k_flush_to_zero | k_denormals_are_zero); }
  ~FlushDenormals() { _mm_setcsr(before_); }

 private:
  static constexpr unsigned k_flush_to_zero = 0x8000, k_denormals_are_zero = 0x0040;
  unsigned before_;

 public:
#else
  FlushDenormals() = default;
#endif
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;
};

}  // namespace recede::detail
