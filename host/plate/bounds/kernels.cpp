#include "host/plate/bounds/kernels.hpp"

#include "host/plate/direct/kernels.hpp"
#include "host/plate/solver.hpp"

namespace palpate::plate::bounds {

RunnableSums runnable_sums() {
    RunnableSums runnable{{&SUM_KERNELS_BASELINE, nullptr, nullptr}, 1};
#ifdef PALPATE_X86_KERNELS
    runnable = {{&SUM_KERNELS_BASELINE, &SUM_KERNELS_V3, &SUM_KERNELS_V4}, runnable_kernels().n};
#endif
    return runnable;
}

const SumKernels& sum_kernels_for(Kernel kernel) {
    static const RunnableSums RUNNABLE = runnable_sums();
    return *RUNNABLE.sets[kernel == Kernel::portable ? 0 : RUNNABLE.n - 1];
}

}  // namespace palpate::plate::bounds
