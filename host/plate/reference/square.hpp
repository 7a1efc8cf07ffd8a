/// A square patch, uniform, pressed at its middle: the shell in few elements of high order.
#pragma once
#include <cstddef>
#include <span>

#include "host/plate/reference/pressed.hpp"

namespace palpate::reference {

/// Clamped on all edges.
struct Square {
    double side_m = 0.04;
    double thickness_m = 1e-3;
    double rigidity_n_m = 1.0;  ///< D = E h^3/(12 (1 - nu^2))
    double poisson = 0.2;
    double curvature_x_per_m = 0.0;  ///< positive: convex, pressed from outside
    double curvature_z_per_m = 0.0;
    Edge edge = Edge::fixed;
    std::size_t elements = 12;  ///< along half a side, from 4; smaller towards the middle
};

/// As press(Shell), with bicubic Hermite elements for w and both in-plane displacements on a quarter of the
/// square (MATH.md section 15). Of the grid it shares the energy, and neither the strains nor their error:
/// fourth order, and with 12 elements F/(k d) of a flat plate is 5e-5 high at one thickness and 1e-3 at five
/// (24 elements: 1e-5 and 1e-4). 0.1-1 s a depth with 12.
[[nodiscard]] Pressed press(const Square& square, std::span<const double> depths_m);

}  // namespace palpate::reference
