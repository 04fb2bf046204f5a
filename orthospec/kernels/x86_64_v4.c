/* The kernels for x86-64-v4: AVX-512, without its fused operations, which would round otherwise. */
#include "kernels.h"

#if defined(__x86_64__) && defined(__GNUC__)
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx512f,avx512bw,avx512cd,avx512dq,avx512vl,bmi,bmi2,lzcnt,movbe,popcnt"))), apply_to = function)
#else
#pragma GCC target("avx512f,avx512bw,avx512cd,avx512dq,avx512vl,bmi,bmi2,lzcnt,movbe,popcnt")
#endif

#define VARIANT kernels_x86_64_v4
#define NAME "x86-64-v4"
#include "variant.h"

#if defined(__clang__)
#pragma clang attribute pop
#endif
#endif
