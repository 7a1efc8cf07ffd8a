#include "host/plate/iterative/sweep_kernel.inc"

namespace palpate::plate {

const SweepKernel SWEEP_KERNEL_V4 = kernel_named("x86-64-v4");

}  // namespace palpate::plate
