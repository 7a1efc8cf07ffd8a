/// The compliances of a table: at m x m nodes over the central half of a plate, extrapolated from its grids.
#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "host/plate/plate.hpp"

namespace palpate::plate {

/// m x m nodes of a grid, evenly spaced from a quarter to three quarters of it, ix fastest. Throws
/// std::invalid_argument unless both counts are 4 k + 1 and (count - 1)/2 is a multiple of m - 1.
[[nodiscard]] std::vector<Node> contact_nodes(Eigen::Index nx, Eigen::Index nz, Eigen::Index m);

/// A plate on one of its grids, both borrowed: `plate` has the rigidity of `problem`.
struct OnGrid {
    const Problem& problem;
    const Plate& plate;
};
