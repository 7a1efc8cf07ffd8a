#include "host/plate/iterative/sweep_kernel.inc"

namespace palpate::plate {

const SweepKernel SWEEP_KERNEL_BASELINE = kernel_named("baseline");

}  // namespace palpate::plate
