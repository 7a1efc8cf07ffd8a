/// Grids of one plate, each made of the finer one's every second node, and one V-cycle through them.
#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "host/plate/iterative/sweeper.hpp"
#include "host/plate/iterative/transfer.hpp"
#include "host/plate/plate.hpp"

namespace palpate::plate {

/// An approximation of K^-1 that is symmetric and positive definite: V(2,2) with Chebyshev's polynomial of
/// degree 2 in diag(K)^-1 K as smoother, the energy form anew on each grid with D fully weighted, the
/// coarsest grid solved by Plate (MATH.md eq. 46).
class Hierarchy {
public:
    /// The problem must be valid and can_coarsen. Allocates all that is ever needed. Throws Guard.
    Hierarchy(const Problem& problem, Kernel kernel);
    /// Does not allocate. D positive and finite where there is plate. Throws Guard.
    void set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m);
    /// x = about K^-1 f, in the finest grid's layout, 0 where nothing moves. Memory of its own: one call at a
    /// time.
    void cycle(const double* f, double* x);

    [[nodiscard]] const Sweeper& finest() const { return levels_.front().sweeper; }
    [[nodiscard]] std::size_t n_grids() const { return levels_.size(); }

private:
    /// Vectors in the layout of its grid.
    struct Level {
        Sweeper sweeper;
        Eigen::ArrayXXd rigidity_n_m, room;
        std::vector<double> f, x, other, r;
        double first = 0.0, momentum = 0.0, second = 0.0;  ///< Chebyshev's steps
        double scale = 0.0;  ///< of forces from the finer grid: each has units of its own

        Level(const Problem& problem, const SweepKernel& kernel);
        void set_smoother();
        void smooth_from_zero(const double* rhs, double* to);
        void smooth(const double* rhs, double* at);
    };
    void refresh();
    void descend(std::size_t level, const double* f, double* x);
    void solve_coarsest(const double* f, double* x);

    Mask solid_;
    std::vector<Level> levels_;        ///< the finest first
    std::vector<Transfer> transfers_;  ///< between levels_[i] and levels_[i + 1]
    std::optional<Plate> coarsest_;
    std::vector<double> coarsest_force_n_, coarsest_deflection_m_;  ///< at the nodes
};

}  // namespace palpate::plate
