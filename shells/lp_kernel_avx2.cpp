// The kernel for processors with AVX2; compiled with that switched on, for x86-64 only.
#define RECEDE_KERNEL k_lp_kernel_avx2
#include <recede/shells/detail/kernel/lp_kernel_body.h>
