/// The plates that methods are compared on: unit square, nu = 0.2, clamped, 1 N at the centre.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "host/plate/field.hpp"

namespace palpate::study {

/// a/l of the foundation, l where D = 1.
inline constexpr double FOUNDATION_SIDE_OVER_L = 13.5;

/// A field of rigidity by name.
struct RigidityField {
    std::string name;
    std::string words;  ///< D over the unit square, r from its centre
    plate::Field rigidity_n_m;
    bool uniform = false;
    /// Nodes of the grid on which the continuum is asked; for a jump, one with a line on it.
    Eigen::Index reference_nodes = 257;
    bool on_lines = false;  ///< D jumps on a grid line of every grid of 17 nodes and more: the laminate rule
};

/// uniform linear hyperbolic nodule soft-spot jump jump-on-line random island
[[nodiscard]] std::vector<RigidityField> rigidity_fields();

/// The same on the unit square, on a foundation of `side_over_l` where D = 1; 0: bare.
[[nodiscard]] plate::Sheet sheet_of(const RigidityField& field, double side_over_l);

/// Nearest of 100 sites, each with a D between 1 and `contrast`, evenly in its logarithm. Always the same.
[[nodiscard]] plate::Field random_sites(double contrast, std::uint64_t seed);

}  // namespace palpate::study
