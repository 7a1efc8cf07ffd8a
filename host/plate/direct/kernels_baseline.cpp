#include "host/plate/direct/kernels.inc"

#include "host/plate/direct/batch_kernels.inc"

namespace palpate::plate {

constinit const Kernels KERNELS_BASELINE{
    Baseline::NAME,     assemble<Baseline>,          factor<Baseline>, schur<Baseline>, forward<Baseline>,
    backward<Baseline>, batch_kernels_of<Baseline>()};

}  // namespace palpate::plate
