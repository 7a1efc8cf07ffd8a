/// The paper's equation 7 by central differences, as the paper solves it: a baseline, not for use.
#pragma once
#include <Eigen/SparseLU>

#include "host/plate/solver.hpp"
#include "host/plate/stencil.hpp"

namespace palpate::plate {

/// What passes the guard is that close to the energy form on the same grid, relative (MATH.md eq. 57).
inline constexpr double EQ7_OFF_ENERGY_FORM = 0.03;

/// D lap^2 w + 2 D_x (lap w)_x + 2 D_z (lap w)_z + lap D lap w - (1 - nu)(D_xx w_zz - 2 D_xz w_xz + D_zz
/// w_xx)
/// + k_f w = q, every derivative by central differences on the grid, w and its slope 0 at the edges, times
/// hx hz (the paper's eq. 7; MATH.md eq. 48). The same matrix as K where D is constant or linear, second
/// order where D is smooth. It is neither symmetric nor positive: once D changes by more than some 1.5 to 2
/// times from node to node it gives compliances that are wrong by any factor, and negative ones. solve()
/// refuses them: D must change by at most 1.8 between neighbours, and the energy form's strain energy must be
/// within 2 % of the forces' work. Of 6000 random fields the 1153 that pass are off the energy form by 2.1 %
/// at most (MATH.md eq. 57). The paper iterates on it with Jacobi's method; here Eigen::SparseLU solves it,
/// so that what is seen is the equation's own error. set_rigidity and solve allocate.
class Eq7 final : public Solver {
public:
    /// Throws std::invalid_argument with problem_with(problem), and for edges that are not clamped, a
    /// Poisson's ratio that varies, moved grid lines, a mask, or jumps on grid lines; Guard when the matrix
    /// is singular.
    explicit Eq7(const Problem& problem);
    void set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m) override;
    /// Throws Guard when the work of the forces is not positive or the result cannot be trusted.
    [[nodiscard]] Report solve(std::span<const double> force_n,
                               std::span<double> deflection_m) const override;
    [[nodiscard]] std::string kernel() const override { return "eigen"; }

private:
    void factorise(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m);
    void require_factor() const;
    void require_trust(const std::vector<double>& x, const std::vector<double>& f) const;

    Stencil stencil_;       ///< for its layout and units; its K is not used
    Eigen::Vector2d step_;  ///< over the side along x
    double poisson_;
    double step_max_ = 1.0;  ///< of D between neighbours
    Eigen::ArrayXXd foundation_n_per_m3_;
    Eigen::SparseMatrix<double> matrix_;
    Eigen::SparseLU<Eigen::SparseMatrix<double>> lu_;
};

}  // namespace palpate::plate
