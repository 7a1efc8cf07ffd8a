/// Jacobi's iteration on K w = f, the paper's method.
#pragma once
#include <Eigen/Core>
#include <mutex>
#include <vector>

#include "host/plate/iterative/sweeper.hpp"
#include "host/plate/solver.hpp"

namespace palpate::plate {

/// w' = w + omega diag(K)^-1 (f - K w) from w = 0 (MATH.md eq. 44). The paper has omega = 1 and its equation
/// 7 in place of K; for uniform D they are the same matrix. Errors grow when omega exceeds 2/lambda, lambda
/// the largest eigenvalue of diag(K)^-1 K: 3.2 where D is smooth (2.2 times a sweep for omega = 1), up to
/// some 3.4 where it is rough, and there even the damped iteration diverges. Otherwise they shrink by 1 - 65
/// omega/n^4 a sweep on n x n clamped nodes.
///
/// Diverged: an update is not finite or a million times the first. Memory for one solution at a time: calls
/// of solve() wait for each other. Neither set_rigidity nor solve allocates.
class Jacobi final : public Solver {
public:
    static constexpr double PLAIN = 1.0, DAMPED = 0.62;

    /// Throws std::invalid_argument with problem_with(problem).
    Jacobi(const Problem& problem, const Options& options, double omega);
    void set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m) override;
    [[nodiscard]] Report solve(std::span<const double> force_n,
                               std::span<double> deflection_m) const override;
    [[nodiscard]] std::string kernel() const override { return sweeper_.kernel().name; }

private:
    [[nodiscard]] Report iterate(double f_max) const;
    [[nodiscard]] double residual(double f_max) const;

    Mask solid_;
    Sweeper sweeper_;
    Options options_;
    double omega_;
    mutable std::mutex one_at_a_time_;
    mutable std::vector<double> f_, x_, next_;
};

}  // namespace palpate::plate
