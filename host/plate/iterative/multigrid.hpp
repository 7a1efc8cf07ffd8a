/// Conjugate gradients with one multigrid cycle as preconditioner.
#pragma once
#include <Eigen/Core>
#include <mutex>
#include <vector>

#include "host/plate/iterative/hierarchy.hpp"
#include "host/plate/solver.hpp"

namespace palpate::plate {

/// K w = f by conjugate gradients, preconditioned by Hierarchy::cycle. O(nodes) for smooth D: 3 iterations to
/// an error of 1e-3 and 9 to 1e-6 on every grid; some 10 and 30 for a random D of contrast 1000, more than
/// 150 for jumps of 1e6. It cannot see a matrix that is too badly conditioned, as the direct method can:
/// meant for smooth D on fine grids.
///
/// Solved: the true residual is within the tolerance. Not converged: sweeps_max iterations, or no progress in
/// 50. Diverged: p'K p or r'z is not positive and finite. Memory for one solution at a time: calls of solve()
/// wait for each other. Neither set_rigidity nor solve allocates. StopRule::change is refused.
class Multigrid final : public Solver {
public:
    /// Throws std::invalid_argument with problem_with(problem), or when the grid cannot be made coarser: node
    /// counts must be odd and at least 9, and should be 2^k m + 1 with a small m; Guard.
    Multigrid(const Problem& problem, const Options& options);
    void set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m) override;
    [[nodiscard]] Report solve(std::span<const double> force_n,
                               std::span<double> deflection_m) const override;
    [[nodiscard]] std::string kernel() const override { return hierarchy_.finest().kernel().name; }

private:
    [[nodiscard]] Report iterate(double f_max) const;

    Mask solid_;
    Options options_;
    mutable std::mutex one_at_a_time_;
    mutable Hierarchy hierarchy_;
    mutable std::vector<double> f_, x_, r_, p_, q_, z_;
};

}  // namespace palpate::plate
