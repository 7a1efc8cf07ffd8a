/// The table behind the depth law.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace palpate::reference {

/// F/(k d) at d = x h for a point load, k the linear stiffness, nu = 0.2.
struct DepthTable {
    std::vector<double> x;
    std::vector<double> flat;     ///< square clamped plate, in-plane fixed
    std::vector<double> convex;   ///< spherical cap pressed from outside
    std::vector<double> concave;  ///< the same from inside
};

/// Flat: Square of so many `elements`. Caps: radius 12 l, mean of the in-plane fixed and the in-plane free
/// rim. Throws std::runtime_error when Ceres finds no minimum.
[[nodiscard]] DepthTable depth_table(const std::vector<double>& x, std::size_t elements);

/// The table of host/plate/depth_law_table.inc. A minute.
[[nodiscard]] std::string depth_table_text();

}  // namespace palpate::reference
