#include "host/plate/iterative/sweep_kernel.inc"

namespace palpate::plate {

const SweepKernel SWEEP_KERNEL_V3 = kernel_named("x86-64-v3");

}  // namespace palpate::plate
