#include "host/plate/direct/kernels.inc"

#include "host/plate/direct/batch_kernels.inc"

namespace palpate::plate {

constinit const Kernels KERNELS_V4{V4::NAME,     assemble<V4>,          factor<V4>, schur<V4>, forward<V4>,
                                   backward<V4>, batch_kernels_of<V4>()};

}  // namespace palpate::plate
