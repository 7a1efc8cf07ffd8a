#include "host/plate/iterative/sweeper.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::plate {

namespace {

std::vector<const SweepKernel*> runnable() {
    std::vector<const SweepKernel*> kernels{&SWEEP_KERNEL_BASELINE};
#ifdef PALPATE_X86_KERNELS
    // All that the compiler may use under -march=x86-64-v3 and -v4, and the operating system keeps.
    const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                    __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
                    __builtin_cpu_supports("popcnt");
    const bool v4 = v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                    __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                    __builtin_cpu_supports("avx512vl");
    if (v3) kernels.push_back(&SWEEP_KERNEL_V3);
    if (v4) kernels.push_back(&SWEEP_KERNEL_V4);
#endif
    return kernels;
}

}  // namespace

std::span<const SweepKernel* const> sweep_kernels() {
    static const std::vector<const SweepKernel*> kernels = runnable();
    return kernels;
}

const SweepKernel& sweep_kernel(Kernel kernel) {
    return kernel == Kernel::portable ? *sweep_kernels().front() : *sweep_kernels().back();
}

Sweeper::Sweeper(const Problem& problem, const SweepKernel& kernel)
    : stencil_(problem), kernel_(&kernel), inverse_diagonal_(stencil_.layout().size(), 0.0) {
    refresh();
}

void Sweeper::set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m) {
    stencil_.set_rigidity(rigidity_n_m);
    refresh();
}

SweepGrid Sweeper::grid() const {
    static_assert(SweepGrid::N_FORWARD == N_COUPLINGS - 1);
    const Layout& layout = stencil_.layout();
    const Moving& moving = stencil_.moving();
    SweepGrid grid{inverse_diagonal_.data(),
                   stencil_.coupling(CENTRE),
                   {},
                   {},
                   layout.at(moving.x0, moving.z0),
                   layout.at(moving.x1 - 1, moving.z1 - 1) + 1};
    for (std::size_t k = X1; k < N_COUPLINGS; ++k) {
        grid.forward[k - 1] = stencil_.coupling(static_cast<Coupling>(k));
        grid.offset[k - 1] = OFFSETS[k].dx + OFFSETS[k].dz * layout.stride();
    }
    return grid;
}

void Sweeper::refresh() {
    const SweepGrid g = grid();
    bound_ = 0.0;
    for (std::size_t c = g.first; c < g.end; ++c) {
        if (!(g.centre[c] > 0.0)) continue;  // cannot move
        inverse_diagonal_[c] = 1.0 / g.centre[c];
        double row = g.centre[c];
        for (std::size_t k = 0; k < SweepGrid::N_FORWARD; ++k) {
            const double* const here = g.forward[k] + c;
            row += std::fabs(here[0]) + std::fabs(here[-g.offset[k]]);
        }
        bound_ = std::max(bound_, row * inverse_diagonal_[c]);
    }
}

}  // namespace palpate::plate
