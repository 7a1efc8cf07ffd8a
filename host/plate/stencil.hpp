/// The stiffness matrix K = B'CB of a plate as a 13-point stencil (MATH.md eq. 2-4, 30-31): what the methods
/// share.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "host/plate/problem.hpp"

namespace palpate::plate {

/// Of the largest D: what stands where there is no plate, so that its rim is free (MATH.md section 9).
inline constexpr double FREE_EDGE = 1e-6;

/// Nodes [x0, x1) x [z0, z1): those that can move. Nodes on clamped and supported edges cannot.
struct Moving {
    Eigen::Index x0, x1, z0, z1;
    Moving(Eigen::Index nx, Eigen::Index nz, const std::array<Edge, 4>& edges);
    [[nodiscard]] Eigen::Index count() const { return (x1 - x0) * (z1 - z0); }
    [[nodiscard]] bool holds(Eigen::Index ix, Eigen::Index iz) const {
        return ix >= x0 && ix < x1 && iz >= z0 && iz < z1;
    }
    auto operator<=>(const Moving&) const = default;
};

/// Node (ix, iz) of a grid with two rows of zeros around it, so that a stencil needs no branches; x runs
/// fastest.
struct Layout {
    static constexpr Eigen::Index PADDING = 2;
    Eigen::Index nx, nz;
    [[nodiscard]] Eigen::Index stride() const { return nx + 2 * PADDING; }
    [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(stride() * (nz + 2 * PADDING)); }
    [[nodiscard]] std::size_t at(Eigen::Index ix, Eigen::Index iz) const {
        return static_cast<std::size_t>(ix + PADDING + (iz + PADDING) * stride());
    }
};

/// The half of the stencil that points forward in a Layout; the rest is its mirror image.
enum Coupling : std::size_t {
    CENTRE,
    X1,   ///< (+1, 0)
    X2,   ///< (+2, 0)
    ZM1,  ///< (-1, +1)
    Z1,   ///< (0, +1)
    ZP1,  ///< (+1, +1)
    Z2,   ///< (0, +2)
    N_COUPLINGS
};
struct Offset {
    Eigen::Index dx, dz;
};
inline constexpr std::array<Offset, N_COUPLINGS> OFFSETS{
    {{0, 0}, {1, 0}, {2, 0}, {-1, 1}, {0, 1}, {1, 1}, {0, 2}}};

/// Second differences along one axis, and what of it each node and cell owns. Lengths over the plate's side
/// along x. Entry i + PADDING is node i; zero beyond the ends.
struct Lines {
    std::vector<double> before, centre, after;  ///< w'' at i = before w_(i-1) + centre w_i + after w_(i+1)
    std::vector<double> share;                  ///< of the node
    std::vector<double> cell;                   ///< length of the cell from i to i + 1
    std::vector<double> free;                   ///< 1 at a free end, else 0
};

/// K in units of D_max/side^2, D_max the problem's largest rigidity and side its size along x.
class Stencil {
public:
    /// The problem must be valid. Allocates.
    explicit Stencil(const Problem& problem);
    /// K for another D on the same grid, all else as before: no jumps on grid lines. Does not allocate. The
    /// values must be positive and finite. O(nodes), about 6 ns each.
    void set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m);

    [[nodiscard]] const Layout& layout() const { return layout_; }
    [[nodiscard]] const Moving& moving() const { return moving_; }
    /// K(node, node + OFFSETS[c]) at Layout::at; 0 where either end cannot move.
    [[nodiscard]] const double* coupling(Coupling c) const { return k_.data() + c * layout_.size(); }
    /// All of them, each of layout().size() numbers, one behind the other.
    [[nodiscard]] const double* couplings() const { return k_.data(); }
    /// y = K x, both in the layout, x zero where nothing moves.
    void apply(const double* x, double* y) const;
    /// Deflection in m per newton of one unit of K^-1.
    [[nodiscard]] double compliance_m_per_n() const { return side_m_ * side_m_ / scale_n_m_; }
    [[nodiscard]] double side_m() const { return side_m_; }

private:
    /// Of every node and cell: what multiplies w_xx^2, w_zz^2, 2 w_xx w_zz, and the squared corner sum.
    void weigh(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m);
    /// The same where D jumps along grid lines.
    void laminate(const Problem& problem);
    void couple();
    void cut_ends();

    Layout layout_;
    Moving moving_;
    Lines x_, z_;
    double side_m_, scale_n_m_ = 1.0;
    Mask solid_;
    std::vector<double> poisson_, foundation_;  ///< in the layout; the foundation in N/m per unit of scale
    std::vector<double> xx_, zz_, xz_, twist_;
    std::vector<double> node_;  ///< a row of D over the scale
    std::vector<double> k_;     ///< the couplings, one behind the other
};

}  // namespace palpate::plate
