/// How much a field varies, and what a grid cannot know of its jumps.
#pragma once
#include <Eigen/Core>

#include "host/plate/field.hpp"
#include "host/plate/loads.hpp"

namespace palpate::plate {

/// Largest ratio of D between neighbours that a grid resolves.
inline constexpr double SMOOTH_STEP = 1.3;

/// Largest over smallest value, and the largest ratio between neighbours. An empty field is uniform.
struct Variation {
    double contrast = 1.0, step = 1.0;
    explicit Variation(const Eigen::ArrayXXd& field);
    [[nodiscard]] bool uniform() const { return contrast <= 1.0 + 1e-12; }
};

enum class Extreme { softest, stiffest };

/// The softest or stiffest D that each node can be said to have: its own or that beyond a jump on the way to
/// one of its eight neighbours. Jumps on the grid lines themselves are no doubt: the laminate rule has them.
[[nodiscard]] Eigen::ArrayXXd beyond_jumps(const Sheet& sheet, const Problem& on_grid, Extreme which);

}  // namespace palpate::plate
