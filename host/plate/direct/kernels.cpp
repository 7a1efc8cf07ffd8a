#include "host/plate/direct/kernels.hpp"

#include "host/plate/solver.hpp"

namespace palpate::plate {

RunnableKernels runnable_kernels() {
    RunnableKernels runnable{{&KERNELS_BASELINE, nullptr, nullptr}, 1};
#ifdef PALPATE_X86_KERNELS
    // All that the compiler may use under -march=x86-64-v3 and -v4; the operating system's part is in it.
    __builtin_cpu_init();
    const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                    __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
                    __builtin_cpu_supports("popcnt") && __builtin_cpu_supports("sse4.2");
    const bool v4 = v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                    __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                    __builtin_cpu_supports("avx512vl");
    if (v3) runnable.sets[runnable.n++] = &KERNELS_V3;
    if (v4) runnable.sets[runnable.n++] = &KERNELS_V4;
#endif
    return runnable;
}

const Kernels& kernels_for(Kernel kernel) {
    static const RunnableKernels RUNNABLE = runnable_kernels();
    return *RUNNABLE.sets[kernel == Kernel::portable ? 0 : RUNNABLE.n - 1];
}

}  // namespace palpate::plate
