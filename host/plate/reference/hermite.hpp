/// Cubic Hermite elements on [0, 1], smaller towards 0.
#pragma once
#include <array>
#include <cmath>
#include <cstddef>

namespace palpate::reference {

/// Gauss-Legendre on [0, 1].
struct GaussPoint {
    double place;
    double weight;
};
inline constexpr std::array<GaussPoint, 4> GAUSS = {{{0.06943184420297371, 0.17392742256872692},
                                                     {0.33000947820757187, 0.32607257743127307},
                                                     {0.66999052179242813, 0.32607257743127307},
                                                     {0.93056815579702629, 0.17392742256872692}}};

/// By node and order: the value and the slope at the element's first node, then at its second.
using HermiteFactors = std::array<double, 4>;

/// What the four make at a point: itself, its derivative, its second derivative.
using HermiteShape = std::array<HermiteFactors, 3>;

/// At `t` in [0, 1] of an element of length `h`.
[[nodiscard]] inline HermiteShape hermite_shape(double t, double h) {
    const double t2 = t * t;
    const double t3 = t2 * t;
    return {{{1.0 - 3.0 * t2 + 2.0 * t3, h * (t - 2.0 * t2 + t3), 3.0 * t2 - 2.0 * t3, h * (t3 - t2)},
             {6.0 * (t2 - t) / h, 1.0 - 4.0 * t + 3.0 * t2, 6.0 * (t - t2) / h, 3.0 * t2 - 2.0 * t},
             {(12.0 * t - 6.0) / h / h, (6.0 * t - 4.0) / h, (6.0 - 12.0 * t) / h / h, (6.0 * t - 2.0) / h}}};
}

/// Place of a node of `elements`.
[[nodiscard]] inline double graded(std::size_t node, std::size_t elements) {
    const double even = static_cast<double>(node) / static_cast<double>(elements);
    return even * even;
}

}  // namespace palpate::reference
