/// Loads as forces at nodes, and deflections between nodes.
#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "host/plate/problem.hpp"

namespace palpate::plate {

/// The grid lines of a problem in m, even ones too.
struct GridLines {
    Eigen::ArrayXd x_m, z_m;
    explicit GridLines(const Problem& problem);
};

/// How a force between nodes comes onto them: by cubic Lagrange weights onto the 4 x 4 nodes around it, some
/// of them negative, or by linear ones onto the 2 x 2, none negative.
enum class Spread { cubic, linear };

/// Adds a force at a place to the nodes around it: on a node all goes there. With cubic weights its transpose
/// is deflection_at, so that the work is right.
void add_force(const GridLines& lines, const Eigen::Vector2d& at_m, double force_n,
               std::span<double> at_nodes_n, Spread spread = Spread::cubic);
/// Deflection at a place from the 4 x 4 nodes around it.
[[nodiscard]] double deflection_at(const GridLines& lines, const Eigen::Vector2d& at_m,
                                   std::span<const double> at_nodes_m);

/// Forces at the nodes, (ix, iz), ix fastest, of 1 N spread evenly over a disc; of radius 0, a point. Rings
/// and rays finer than the grid.
[[nodiscard]] std::vector<double> unit_pressure(const GridLines& lines, const Eigen::Vector2d& at_m,
                                                double radius_m, Spread spread = Spread::cubic);

/// Nodes within a disc, and the node nearest its centre if there are none: where a flat rigid punch touches.
[[nodiscard]] std::vector<Node> touched_nodes(const GridLines& lines, const Eigen::Vector2d& at_m,
                                              double radius_m);

}  // namespace palpate::plate
