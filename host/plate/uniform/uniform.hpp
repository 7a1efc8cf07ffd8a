/// The uniform clamped square with a load at its centre: side 1, D = 1, a/l = side_over_l.
#pragma once
#include <Eigen/Core>

#include "host/plate/plate.hpp"

namespace palpate::plate {

/// Centre compliance C flattened to a function near 1 everywhere, C = flat/(8 sqrt(s^4 + 496)), and back.
[[nodiscard]] double flattened(double compliance, double side_over_l);
[[nodiscard]] double unflattened(double flat, double side_over_l);

/// The square of `n` x `n` nodes.
[[nodiscard]] Problem uniform_square(Eigen::Index n, double side_over_l);

/// Its centre compliance on that grid, raw: interpolated (within 1e-9) from 17 plates per interval of a/l
/// that each thread solves when first asked (7 ms at n = 33); up to a/l = 96, solved every time beyond.
[[nodiscard]] double uniform_square_grid_compliance(Eigen::Index n, double side_over_l);

/// Grid error of the compliance at a node as the uniform square about it has it: same spacing (mean of x and
/// z), same D and k_f (MATH.md eq. 8). The node must be inside.
[[nodiscard]] double local_grid_error_m_per_n(const Problem& problem, const Node& load);

}  // namespace palpate::plate
