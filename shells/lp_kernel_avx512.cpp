// The kernel for processors with AVX-512; compiled with that switched on, for x86-64 only.
#define RECEDE_KERNEL k_lp_kernel_avx512
#include <recede/shells/detail/kernel/lp_kernel_body.h>
