// The kernel for processors with AVX2; compiled with that switched on, for x86-64 only.
#define RECEDE_KERNEL k_displaced_kernel_avx2
#include <recede/render/detail/kernel/displaced_kernel_body.h>
