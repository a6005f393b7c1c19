// The kernel for any processor, and the choice of the version that runs.
#define RECEDE_KERNEL k_lp_kernel_baseline
#include <recede/shells/detail/kernel/lp_kernel_body.h>

namespace recede::detail {

const LpKernel& lp_kernel() {
#if defined(RECEDE_AVX_KERNELS)
  static const bool has_avx512 = __builtin_cpu_supports("avx512f") != 0;
  static const bool has_avx2 = __builtin_cpu_supports("avx2") != 0;
  // A single point has no use for more than four lanes.
  static const LpKernel widest = {k_lp_kernel_avx2.sum, k_lp_kernel_avx512.sum_packet,
                                  k_lp_kernel_avx512.sum_each};
  if (has_avx512 && has_avx2) return widest;
  if (has_avx2) return k_lp_kernel_avx2;
#endif
  return k_lp_kernel_baseline;
}

}  // namespace recede::detail
