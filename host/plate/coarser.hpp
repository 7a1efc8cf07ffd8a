/// The same plate on fewer nodes.
#pragma once
#include <Eigen/Core>

#include "host/plate/problem.hpp"

namespace palpate::plate {

/// Every second node, corners included; the counts must be odd.
[[nodiscard]] Problem every_second_node(const Problem& fine);
[[nodiscard]] Eigen::ArrayXXd every_second_node(const Eigen::Ref<const Eigen::ArrayXXd>& fine);

/// Three spacings where there were four: grid lines, D, k_f (not below 0) and Poisson's ratio from quintics
/// through the nearest six nodes along x, then z. For smooth fields: D may come out negative beside a jump,
/// which Plate refuses. Throws std::invalid_argument unless the counts are 4 k + 1 and at least 9, and for
/// holes and jumps along grid lines.
[[nodiscard]] Problem three_quarters(const Problem& fine);
[[nodiscard]] Eigen::ArrayXXd three_quarters(const Eigen::Ref<const Eigen::ArrayXXd>& fine);

/// More than a factor of 2 between neighbours: methods lose their order (MATH.md eq. 10). Empty: no.
[[nodiscard]] bool has_jump(const Eigen::Ref<const Eigen::ArrayXXd>& field);

}  // namespace palpate::plate
