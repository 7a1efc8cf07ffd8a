/// The compliances of a table: at m x m nodes over the central half of a plate, extrapolated from its grids.
#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "host/plate/plate.hpp"

namespace palpate::plate {

/// m x m nodes of a grid, evenly spaced from a quarter to three quarters of it, ix fastest. Throws
/// std::invalid_argument unless both counts are 4 k + 1 and (count - 1)/2 is a multiple of m - 1.
[[nodiscard]] std::vector<Node> contact_nodes(Eigen::Index nx, Eigen::Index nz, Eigen::Index m);

/// Deflection in m at each of contact_nodes under 1 N there, in the continuum, for one D after another.
/// Solved on all, half and three quarters of the nodes, from what is known at the nodes. With G the
/// compliance less the local uniform square's grid error (MATH.md eq. 8), contacts that are nodes of several
/// grids take the limit of the polynomial in h^2 through their G; the ratio that a grid brings is
/// interpolated by cubics to the others (MATH.md eq. 56). Any edges. Relative error, 17 x 17 contacts, D and
/// k_f smooth over five spacings of 65 nodes, to a/l = 8: 5e-4 from 33 nodes, 2e-5 from 65, mostly a tenth of
/// that. Where three quarters do not serve (a jump of D or k_f, holes, jumps along grid lines, a Poisson's
/// ratio at nodes, counts or contacts that do not fit) on two grids alone: for smooth D 2e-3 and 1.2e-4;
/// beside jumps see MATH.md eq. 10.
class ContactTable {
public:
    /// Throws as contact_nodes and Plate do, std::invalid_argument when half the nodes have no contacts.
    ContactTable(const Problem& problem, Eigen::Index m, Kernel kernel = Kernel::portable);
    /// Another D on the same grid. Throws as Plate::set_rigidity does.
    void set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m);
    /// m x m. O(m^2 nodes): with set_rigidity 0.45 ms for 17 x 17 of 33 nodes, AVX-512. Throws Guard when a
    /// compliance is not positive, and as Plate does after a D that it refused.
    [[nodiscard]] Eigen::ArrayXXd compliances_m_per_n() const;
    /// Grids that the present D is solved on: 3, or 2.
    [[nodiscard]] int n_grids() const { return smooth_ ? 3 : 2; }

private:
    struct Grid {
        Problem problem;
        Plate plate;
        Eigen::Index stride;  ///< the contacts that are nodes: every one, every second or fourth

        Grid(const Problem& on_grid, Eigen::Index every, Kernel kernel);
        void set_rigidity(const Eigen::ArrayXXd& rigidity_n_m);
        [[nodiscard]] Eigen::ArrayXXd corrected_m_per_n(Eigen::Index m) const;
    };
    void set_third(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m);

    Eigen::Index m_;
    Grid all_, half_;
    std::optional<Grid> three_quarters_;
    bool smooth_ = false;
};

/// The same once.
[[nodiscard]] Eigen::ArrayXXd contact_compliances_m_per_n(const Problem& problem, Eigen::Index m,
                                                          Kernel kernel = Kernel::portable);

}  // namespace palpate::plate
