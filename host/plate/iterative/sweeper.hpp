/// A plate's stencil made ready for sweeps.
#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "host/plate/iterative/sweep_kernel.hpp"
#include "host/plate/solver.hpp"
#include "host/plate/stencil.hpp"

namespace palpate::plate {

/// The kernels that this machine can run, the plainest first.
[[nodiscard]] std::span<const SweepKernel* const> sweep_kernels();
/// `portable`: the first of them; `best`: the last.
[[nodiscard]] const SweepKernel& sweep_kernel(Kernel kernel);

/// Vectors are in the stencil's layout, 0 where nothing moves.
class Sweeper {
public:
    /// The problem must be valid. Allocates.
    Sweeper(const Problem& problem, const SweepKernel& kernel);
    /// As Stencil::set_rigidity. Does not allocate.
    void set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m);

    [[nodiscard]] const Stencil& stencil() const { return stencil_; }
    [[nodiscard]] const SweepKernel& kernel() const { return *kernel_; }
    /// Points into this object; valid until the next set_rigidity.
    [[nodiscard]] SweepGrid grid() const;
    /// Upper bound of the eigenvalues of diag(K)^-1 K: the largest sum of a row's magnitudes over its
    /// diagonal (Gershgorin). 3.2 for uniform D; never too small, which a power iteration may be.
    [[nodiscard]] double eigenvalue_bound() const { return bound_; }

private:
    void refresh();

    Stencil stencil_;
    const SweepKernel* kernel_;
    std::vector<double> inverse_diagonal_;
    double bound_ = 0.0;
};

}  // namespace palpate::plate
