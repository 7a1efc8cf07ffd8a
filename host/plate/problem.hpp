/// A plate on a grid: what every method solves.
#pragma once
#include <Eigen/Core>
#include <array>
#include <optional>
#include <stdexcept>
#include <string>

namespace palpate::plate {

/// How an edge is held: w = 0 and no slope; w = 0 and no moment; not at all.
enum class Edge { clamped, supported, free };

using Mask = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>;

/// A rectangular plate on a grid. Arrays are (ix, iz), corner to corner, edge nodes included.
struct Problem {
    Eigen::Vector2d size_m{0.04, 0.04};
    Eigen::ArrayXXd rigidity_n_m;  ///< flexural rigidity D at the nodes, > 0; at least 5 x 5
    Eigen::ArrayXXd
        foundation_n_per_m3;           ///< restoring pressure per deflection at the nodes, >= 0; empty: none
    double poisson = 0.2;              ///< in (-1, 0.5)
    std::array<Edge, 4> edges{};       ///< x low, x high, z low, z high
    Eigen::ArrayXXd poisson_at_nodes;  ///< in (-1, 0.5); empty: `poisson` everywhere
    /// Harmonic means of D on the two sides of each node, across x and across z: the laminate rule at jumps
    /// of D along grid lines (MATH.md eq. 31). Between 0 and rigidity_n_m; empty: D does not jump.
    Eigen::ArrayXXd harmonic_x_n_m, harmonic_z_n_m;
    Mask solid;  ///< false: no plate there (a hole, an outline); empty: plate everywhere
    /// Grid lines in m, ascending from 0 to size_m; empty: evenly spaced.
    Eigen::ArrayXd lines_x_m, lines_z_m;
};

struct Node {
    Eigen::Index ix, iz;
};

/// The first thing wrong with `problem`, in words for a person; nullopt when it can be solved.
[[nodiscard]] std::optional<std::string> problem_with(const Problem& problem);
/// `problem`. Throws std::invalid_argument with problem_with(problem).
const Problem& require_problem(const Problem& problem);
/// A number in words for a person.
[[nodiscard]] std::string number_text(double value, int digits = 6);
/// How words for a person name a node.
[[nodiscard]] std::string node_text(Eigen::Index ix, Eigen::Index iz);

/// A number that no guard can vouch for.
struct Guard : std::runtime_error {
    using std::runtime_error::runtime_error;
};

}  // namespace palpate::plate
