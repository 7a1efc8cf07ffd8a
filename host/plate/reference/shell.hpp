/// The von Karman plate and the shallow shell: large deflections, membrane strains and initial curvature.
#pragma once
#include <span>

#include "host/plate/reference/linear.hpp"
#include "host/plate/reference/pressed.hpp"

namespace palpate::reference {

/// `plate.depth_m` is not read. Deflection is positive into the body; a positive curvature is convex.
struct Shell {
    Plate plate;
    double thickness_m = 1e-3;
    double curvature_x_per_m = 0.0;
    double curvature_z_per_m = 0.0;
    Edge edge = Edge::fixed;
};

/// Minimises bending and membrane energy with the contact node held at each of `depths_m` (MATH.md eq. 40).
/// Begin with the smallest depth: each starts from the one before. Second order in the spacing with a
/// logarithm, once that resolves l = sqrt(R h)/(12 (1 - nu^2))^(1/4) and, at d > 2 h, the bending layers
/// about 0.3 size h/d wide: F/(k d) of a flat plate from 33 and 49 nodes, extrapolated, is 0.2 % low at one
/// thickness, 0.6 % at two, 2.4 % at five. Throws std::runtime_error when Ceres finds no minimum. 0.1-1 s a
/// depth at 33 x 33.
[[nodiscard]] Pressed press(const Shell& shell, std::span<const double> depths_m);

}  // namespace palpate::reference
