#include "host/plate/bounds/kernels.inc"

namespace palpate::plate::bounds {

const SumKernels SUM_KERNELS_V4 = kernels_named("x86-64-v4");

}  // namespace palpate::plate::bounds
