#include "host/plate/bounds/kernels.inc"

namespace palpate::plate::bounds {

const SumKernels SUM_KERNELS_V3 = kernels_named("x86-64-v3");

}  // namespace palpate::plate::bounds
