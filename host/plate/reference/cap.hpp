/// A round patch of a sphere, pressed at its middle: the shallow shell in one dimension.
#pragma once
#include <cstddef>
#include <span>

#include "host/plate/reference/pressed.hpp"

namespace palpate::reference {

/// Uniform; clamped at the rim.
struct Cap {
    double radius_m = 0.02;  ///< of the patch
    double thickness_m = 1e-3;
    double rigidity_n_m = 1.0;  ///< D = E h^3/(12 (1 - nu^2))
    double poisson = 0.2;
    double curvature_per_m = 0.0;  ///< positive: convex, pressed from outside
    Edge edge = Edge::fixed;
    std::size_t elements = 64;  ///< from 4; smaller towards the middle
};

/// l = (D/(E h kappa^2))^(1/4): how far a load on a shell is felt.
[[nodiscard]] double shell_length_m(double thickness_m, double curvature_per_m, double poisson);

/// As press(Shell), with cubic Hermite elements in the radius for w and u (MATH.md section 15). Fourth order:
/// with 64 elements k is right to 1e-6 and F/(k d) at five thicknesses to 3e-6. Milliseconds a depth; beyond
/// some fifty thicknesses Ceres needs hundreds of iterations and may give up.
[[nodiscard]] Pressed press(const Cap& cap, std::span<const double> depths_m);

}  // namespace palpate::reference
