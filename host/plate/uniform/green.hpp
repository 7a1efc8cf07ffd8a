/// Green's function of the screened Laplacian on a rectangle, from which the uniform supported plate follows.
#pragma once
#include <Eigen/Core>
#include <complex>

namespace palpate::plate {

/// Li_2 and Li_3, sums of q^k/k^2 and q^k/k^3, of q = e^u: Re u <= 0, |Im u| <= pi. To 1e-15.
struct Polylog {
    std::complex<double> li2, li3;
};
[[nodiscard]] Polylog polylog(std::complex<double> u);

/// G(a, b) + ln|a - b|/(2 pi), finite everywhere: -lap G + i epsilon G = delta(a - b), G = 0 on the edges of
/// the rectangle [0, size], a and b in it. However small `epsilon` > 0, the imaginary part keeps a relative
/// accuracy of its own: -Im G/epsilon, within 1e-15 short side^2, is the deflection at a of the simply
/// supported plate with D = 1, k_f = epsilon^2 under 1 N at b. Re G within GREEN_REAL_ERROR. Cost: 40 + 130
/// sqrt(epsilon) short side terms of Levy's series (MATH.md eq. 35).
[[nodiscard]] std::complex<double> green_without_log(const Eigen::Vector2d& size, double epsilon,
                                                     const Eigen::Vector2d& a, const Eigen::Vector2d& b);

constexpr double GREEN_REAL_ERROR = 6e-13;

}  // namespace palpate::plate
