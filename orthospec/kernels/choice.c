/* Which of the compiled kernels this processor can run. */
#include "kernels.h"

extern const Kernels kernels_base;

#if defined(__x86_64__) && defined(__GNUC__)

extern const Kernels kernels_x86_64_v3, kernels_x86_64_v4;

static int has_v3(void)
{
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
}

static int has_v4(void)
{
    return has_v3() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl");
}

const Kernels *const *kernels_at_hand(void)
{
    static const Kernels *const all[] = {&kernels_x86_64_v4, &kernels_x86_64_v3, &kernels_base, NULL};
    __builtin_cpu_init();
    return has_v4() ? all : has_v3() ? all + 1 : all + 2;
}

#else

const Kernels *const *kernels_at_hand(void)
{
    static const Kernels *const all[] = {&kernels_base, NULL};
    return all;
}

#endif
