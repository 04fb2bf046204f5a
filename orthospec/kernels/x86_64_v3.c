/* The kernels for x86-64-v3: AVX2, without its fused operations, which would round otherwise. */
#include "kernels.h"

#if defined(__x86_64__) && defined(__GNUC__)
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2,bmi,bmi2,lzcnt,movbe,popcnt"))), apply_to = function)
#else
#pragma GCC target("avx2,bmi,bmi2,lzcnt,movbe,popcnt")
#endif

#define VARIANT kernels_x86_64_v3
#define NAME "x86-64-v3"
#include "variant.h"

#if defined(__clang__)
#pragma clang attribute pop
#endif
#endif
