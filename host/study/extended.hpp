/// The plate in 113 bits, by other means: what a method in double is judged by.
#pragma once
#include "host/plate/problem.hpp"

namespace palpate::study {

/// Compliance of the centre node, m/N: K = B'CB (MATH.md eq. 2-4) put together from its squares, banded LDL',
/// all in a type of 113 bits. Shares no code with host/plate. Relative error below 1e-33 times the condition
/// number, 1e-12 at the worst contrast allowed, but for the last rounding. Clamped edges, even grid, odd node
/// counts, no laminate rule: else std::invalid_argument. 0.15 s at 33 x 33 nodes, growing as the
/// longer side times the cube of the shorter.
[[nodiscard]] double extended_centre_compliance_m_per_n(const plate::Problem& problem);

}  // namespace palpate::study
