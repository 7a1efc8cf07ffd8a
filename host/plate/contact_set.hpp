/// The compliances of a table: at m x m nodes over the central half of a plate, extrapolated from two grids.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "host/plate/plate.hpp"

namespace palpate::plate {

/// m x m nodes of a grid, evenly spaced from a quarter to three quarters of it, ix fastest. Throws
/// std::invalid_argument unless both counts are 4 k + 1 and (count - 1)/2 is a multiple of m - 1.
[[nodiscard]] std::vector<Node> contact_nodes(Eigen::Index nx, Eigen::Index nz, Eigen::Index m);

/// Deflection in m at each of contact_nodes under 1 N there, in the continuum. `fine` and `coarse` are the
/// plates of `problem` and of its every second node. With G the compliance less the local uniform square's
/// grid error (MATH.md eq. 8), nodes of both grids have G* = (4 G_fine - G_coarse)/3; at nodes of the fine
/// grid alone the ratio G*/G_fine is interpolated by cubics (MATH.md eq. 56). Smooth D: relative error
/// 5e-4 from 17 + 33 nodes, 3e-5 from 33 + 65. O(m^2 nodes), about 0.4 ms for 17 x 17 of 33 nodes. Throws as
/// the plates do, Guard when a compliance is not positive.
[[nodiscard]] Eigen::ArrayXXd contact_compliances_m_per_n(const Problem& problem, const Plate& fine,
                                                          const Plate& coarse, Eigen::Index m);

}  // namespace palpate::plate
