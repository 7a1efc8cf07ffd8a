/// Multifrontal Cholesky K = L L' over an Analysis, in double, every operation in one fixed order.
#pragma once
#include <memory>
#include <span>

#include "host/plate/direct/analysis.hpp"

namespace palpate::plate {

class Factor {
public:
    /// `values`: the entries of the analysis. Check smallest_pivot_ratio() before the rest: not positive
    /// means that a pivot failed, and L is unusable from there on.
    Factor(std::shared_ptr<const Analysis> analysis, std::span<const double> values);

    /// min L_ii^2/K_ii: a free estimate of 1/condition, and what a rigid motion in soft surroundings shows
    /// in. NaN or not positive when K is not positive definite.
    [[nodiscard]] double smallest_pivot_ratio() const { return smallest_pivot_ratio_; }
    /// Last diagonal entry of the inverse, the centre node's.
    [[nodiscard]] double last_compliance() const;
    /// Replaces a right-hand side, by elimination number, by the solution.
    void solve(std::span<double> x) const;

private:
    /// `updates_end`: end of the stack of Schur complements; takes the children's off it and puts the front's
    /// own on.
    [[nodiscard]] bool eliminate(const Front& front, std::span<const double> values, double* work,
                                 double*& updates_end);
    void keep(const Front& front, std::span<const double> values, const double* work);

    std::shared_ptr<const Analysis> analysis_;
    std::unique_ptr<double[]> panels_;
    double smallest_pivot_ratio_;
};

}  // namespace palpate::plate
