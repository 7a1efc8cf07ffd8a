/// A plate as its owner knows it, and how it comes onto a grid.
#pragma once
#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>

#include "host/plate/problem.hpp"

namespace palpate::plate {

/// Something known all over the plate: of (x_m, z_m) from the plate's corner.
using Field = std::function<double(double x_m, double z_m)>;

/// Of the plate's size: D is asked for this far to either side of a grid line to see whether it jumps there.
inline constexpr double BESIDE = 1e-9;

enum class Sampling { linear, nearest };

/// Values at even places, (i, j), corner to corner of a plate: linear between them, or the nearest (the
/// paper's way; it jumps). A 1 x 1 array is uniform. Throws std::invalid_argument when `values` is empty.
[[nodiscard]] Field sampled(Eigen::ArrayXXd values, const Eigen::Vector2d& size_m,
                            Sampling sampling = Sampling::linear);

/// Independent of any grid. Fields that are not set: no foundation, `poisson` everywhere, plate everywhere.
struct Sheet {
    Eigen::Vector2d size_m{0.04, 0.04};
    Field rigidity_n_m;
    Field foundation_n_per_m3{};
    double poisson = 0.2;
    Field poisson_at{};
    Field solid{};  ///< > 0 where there is plate
    std::array<Edge, 4> edges{};
    /// Values of the finest of the fields along x and along z, corner to corner: a grid of fewer nodes does
    /// not see them all. 1: known by formula, or uniform.
    std::array<Eigen::Index, 2> n_values{1, 1};
};

/// A place that shall be a node, and of how many coarser grids too (each made of every second node).
struct NodeAt {
    Eigen::Vector2d at_m;
    int halvings = 0;
};

/// The sheet on nx x nz nodes. Where D jumps on a grid line the node gets the mean of its sides and their
/// harmonic means (MATH.md eq. 31). With `node_at` the grid lines move smoothly so that this place is a node
/// (MATH.md eq. 32); the closer it is to an edge the less even they are.
[[nodiscard]] Problem on_grid(const Sheet& sheet, Eigen::Index nx, Eigen::Index nz,
                              const std::optional<NodeAt>& node_at = std::nullopt);

[[nodiscard]] Node nearest_node(const Problem& problem, const Eigen::Vector2d& at_m);

}  // namespace palpate::plate
