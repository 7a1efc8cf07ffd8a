/// Eigen's sparse Cholesky on the same matrix: the plain check of the methods of this project.
#pragma once
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "host/plate/solver.hpp"
#include "host/plate/stencil.hpp"

namespace palpate::plate {

/// Lower half of K (Stencil's units) on the nodes that move, x fastest.
[[nodiscard]] Eigen::SparseMatrix<double> sparse_stiffness(const Stencil& stencil);

/// K = L D L' by Eigen::SimplicialLDLT with approximate minimum degree. set_rigidity and solve allocate.
class EigenLdlt final : public Solver {
public:
    /// Throws std::invalid_argument with problem_with(problem), Guard when a pivot is not positive.
    explicit EigenLdlt(const Problem& problem);
    void set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m) override;
    /// Throws Guard when the residual exceeds 1e-7.
    [[nodiscard]] Report solve(std::span<const double> force_n,
                               std::span<double> deflection_m) const override;
    [[nodiscard]] std::string kernel() const override { return "eigen"; }

private:
    void factorise();
    void require_factor() const;

    Mask solid_;
    Stencil stencil_;
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt_;
    bool factorised_ = false;
};

}  // namespace palpate::plate
