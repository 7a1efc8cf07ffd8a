/// Multifrontal Cholesky K = L L' over an Analysis, in double, every operation in one fixed order.
#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "host/plate/direct/analysis.hpp"
#include "host/plate/direct/kernels.hpp"

namespace palpate::plate {

/// Numbers in memory that vectors can be loaded from at once.
class AlignedDoubles {
public:
    /// Holds anything.
    explicit AlignedDoubles(std::size_t n);
    /// Zeros from now on.
    void clear();
    [[nodiscard]] double* data() const { return memory_.get(); }

private:
    struct Free {
        void operator()(double* memory) const;
    };
    std::size_t n_;
    std::unique_ptr<double[], Free> memory_;
};

/// What a solution needs besides the factor; one for each thread.
struct FactorWorkspace {
    explicit FactorWorkspace(const Analysis& analysis);
    AlignedDoubles slots, parent_slots;  ///< of one front
};

/// A factor with less is not to be trusted. Against extended precision the compliance is wrong by less than
/// 2e-14 / pivot ratio (stiff islands up to 1e9), so this leaves 2e-6 at worst. An island 1e6 times stiffer,
/// the contrast of a free edge, has 2e-7 and more.
constexpr double PIVOT_RATIO_MIN = 1e-8;

/// The constructor allocates, nothing else does. Const calls may run in parallel.
class Factor {
public:
    Factor(std::shared_ptr<const Analysis> analysis, const Kernels& kernels);

    /// L of the stencil's K, which must be of the analysis' grid. Check smallest_pivot_ratio() before the
    /// rest: not positive means that a pivot failed, and L is unusable.
    void factorise(const Stencil& stencil);

    /// min L_ii^2/K_ii: a free estimate of 1/condition, and what a rigid motion in soft surroundings shows
    /// in. NaN or not positive when K is not positive definite, and before the first factorise.
    [[nodiscard]] double smallest_pivot_ratio() const { return smallest_pivot_ratio_; }
    /// Last diagonal entry of the inverse, the centre node's.
    [[nodiscard]] double last_compliance() const;
    /// Diagonal entry of the inverse, by elimination number: |L^-1 e|^2, forward from the front that owns the
    /// unknown to the root. O(nodes).
    [[nodiscard]] double compliance(std::size_t number, FactorWorkspace& work) const;
    /// Replaces a right-hand side, by elimination number, by the solution.
    void solve(std::span<double> x, FactorWorkspace& work) const;
    /// The last column of the inverse: half of a solve.
    void solve_last(std::span<double> x, FactorWorkspace& work) const;

    [[nodiscard]] const Analysis& analysis() const { return *analysis_; }
    [[nodiscard]] const Kernels& kernels() const { return *kernels_; }

private:
    [[nodiscard]] FrontView view(const Front& front) const;
    [[nodiscard]] bool eliminate(const Front& front, const double* couplings, double& largest_inverse_ratio);
    void forward(std::span<double> x, FactorWorkspace& work) const;
    void backward(std::span<double> x, FactorWorkspace& work) const;

    std::shared_ptr<const Analysis> analysis_;
    const Kernels* kernels_;
    /// One piece, or glibc would hand its pages back and fetch them anew with every factor of a size.
    AlignedDoubles memory_;
    double *panels_, *updates_;
    double smallest_pivot_ratio_ = -1.0;
};

}  // namespace palpate::plate
