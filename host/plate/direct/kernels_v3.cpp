#include "host/plate/direct/kernels.inc"

#include "host/plate/direct/batch_kernels.inc"

namespace palpate::plate {

constinit const Kernels KERNELS_V3{V3::NAME,     assemble<V3>,          factor<V3>, schur<V3>, forward<V3>,
                                   backward<V3>, batch_kernels_of<V3>()};

}  // namespace palpate::plate
