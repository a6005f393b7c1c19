// The kernel for any processor, and the choice of the version that runs.
#define RECEDE_KERNEL k_displaced_kernel_baseline
#include <recede/render/detail/kernel/displaced_kernel_body.h>

namespace recede::detail {

const DisplacedKernel& displaced_kernel() {
#if defined(RECEDE_AVX2_KERNEL)
  static const bool has_avx2 = __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("bmi2") != 0;
  if (has_avx2) return k_displaced_kernel_avx2;
#endif
  return k_displaced_kernel_baseline;
}

}  // namespace recede::detail
