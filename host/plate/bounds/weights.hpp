/// D and k_f of one question.
#pragma once
#include <span>

#include "host/plate/bounds/kernels.hpp"

namespace palpate::plate::bounds {

/// At the nodes, x fastest, with their reciprocals and extremes. k in units of 1 N m/side^4, side along x;
/// empty: no foundation, and extremes 0.
struct Weights {
    std::span<const double> d, inverse_d, k, inverse_k;
    double d_least, d_most, k_least, k_most;
    const SumKernels* sums;
};

}  // namespace palpate::plate::bounds
