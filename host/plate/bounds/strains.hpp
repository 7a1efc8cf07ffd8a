/// The plate's energy as a sum of squares: K = B' diag(d) B, one row of B for each curvature.
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "host/plate/problem.hpp"

namespace palpate::plate::bounds {

/// Nodes of a grid with one line of zeros around it, so that a stencil needs no branches; x runs fastest.
struct Padded {
    std::size_t nx, nz;
    [[nodiscard]] std::size_t stride() const { return nx + 2; }
    [[nodiscard]] std::size_t size() const { return stride() * (nz + 2); }
    [[nodiscard]] std::size_t at(std::size_t ix, std::size_t iz) const {
        return (ix + 1) + (iz + 1) * stride();
    }
};

/// What a row of B measures. Rows of one kind are stored together, one per padded node; those of TWIST belong
/// to the cell from (ix, iz) to (ix + 1, iz + 1). The weight d of a row is D of its node or cell, k_f for
/// FOUNDATION.
enum Kind : std::size_t { ALONG_X, ALONG_Z, TWIST, FOUNDATION, N_KINDS };

/// B of a problem's grid, edges and Poisson's ratio, lengths over the side along x (MATH.md eq. 2-4, 31, and
/// STRAINS). D, k_f and the laminate rule play no part. Real: double or long double.
template <typename Real>
class Strains {
public:
    /// `problem` valid, one Poisson's ratio, no mask.
    explicit Strains(const Problem& problem);
    [[nodiscard]] const Padded& grid() const { return grid_; }
    [[nodiscard]] std::size_t n_rows() const { return N_KINDS * grid_.size(); }
    [[nodiscard]] bool moves(std::size_t ix, std::size_t iz) const {
        return ix >= x0_ && ix < x1_ && iz >= z0_ && iz < z1_;
    }
    /// strain = B w; w zero at nodes that cannot move and around the grid.
    void strain(const Real* w, Real* strain) const;
    /// force = B' stress, zero at nodes that cannot move.
    void force(const Real* stress, Real* force) const;
    /// Sums of |B| along its rows, in the order of a strain: the strain's rounding errors come from them.
    [[nodiscard]] std::vector<Real> row_sums() const;

private:
    /// Second differences along one axis, one entry of zeros at each end; `root` is sqrt of a node's share.
    struct Axis {
        std::vector<Real> before, centre, after, root, cell;
        bool low_free, high_free;
        Axis(const Eigen::ArrayXd& lines_m, Eigen::Index n, double length_m, double side_m, Edge low,
             Edge high);
        [[nodiscard]] bool free_at(std::size_t i) const {
            return (i == 1 && low_free) || (i + 2 == root.size() && high_free);
        }
    };

    Padded grid_;
    std::size_t x0_, x1_, z0_, z1_;
    Axis x_, z_;
    std::vector<Real> xx_, xz_, zz_, twist_, area_;  ///< ALONG_X = xx w_xx + xz w_zz, ALONG_Z = zz w_zz, ...
};

extern template class Strains<double>;
extern template class Strains<long double>;

}  // namespace palpate::plate::bounds
