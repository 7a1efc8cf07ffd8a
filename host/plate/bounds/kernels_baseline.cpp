#include "host/plate/bounds/kernels.inc"

namespace palpate::plate::bounds {

const SumKernels SUM_KERNELS_BASELINE = kernels_named("baseline");

}  // namespace palpate::plate::bounds
