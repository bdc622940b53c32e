// Inner loops for several generations of processors from one source.
#pragma once

// Before a function: it is compiled for each, and the best is chosen when the program starts.
// Products and sums are rounded one by one in all of them, so the digits are the same everywhere.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define KINETOSTAT_FOR_SEVERAL_PROCESSORS \
  __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define KINETOSTAT_FOR_SEVERAL_PROCESSORS
#endif
