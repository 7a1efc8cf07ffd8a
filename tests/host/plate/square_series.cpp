#include "tests/host/plate/square_series.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace palpate::plate::truth {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

constexpr int N_MOMENTS = 80;
constexpr int LAST_TERM = 40001;  ///< odd; the tail beyond is added in closed form

/// Root of mu^2 = (m pi)^2 + i s^2, so that cosh(mu z) cos(m pi x) solves the plate's equation.
Complex root(int m, double s2) {
    return std::sqrt(Complex(m * pi * m * pi, s2));
}

/// Simply supported plate: sum over odd m of 2 g_m, g_m = -Im(tanh(mu/2)/(2 mu))/s^2 -> 1/(4 (m pi)^3).
double simply_supported(double s2) {
    double sum = 0.0;
    for (int m = LAST_TERM; m >= 1; m -= 2) {
        const Complex mu = root(m, s2);
        sum -= 2.0 * (std::tanh(0.5 * mu) / (2.0 * mu)).imag() / s2;
    }
    const double first_left_out = LAST_TERM + 1.0;
    return sum + 1.0 / (8.0 * pi * pi * pi * first_left_out * first_left_out);
}

}  // namespace

double uniform_square_compliance(double side_over_l) {
    const double s2 = std::max(side_over_l * side_over_l, 1e-6);  // the limit 0 is reached to 1e-12
    Eigen::MatrixXd slope(N_MOMENTS, N_MOMENTS);                  // of mode i on an edge, from moment j
    Eigen::VectorXd load(N_MOMENTS);  // slope by the load; also minus centre deflection
    for (int i = 0; i < N_MOMENTS; ++i) {
        const int m = 2 * i + 1;
        const Complex mu = root(m, s2);
        load(i) = -(1.0 / std::cosh(0.5 * mu)).imag() / s2;
        for (int j = 0; j < N_MOMENTS; ++j) {
            const int n = 2 * j + 1;
            const double sign = (i + j) % 2 == 0 ? 1.0 : -1.0;
            const double sum = pi * pi * (static_cast<double>(m) * m + static_cast<double>(n) * n);
            slope(i, j) = sign * 4.0 * pi * pi * m * n / (sum * sum + s2 * s2);
        }
        slope(i, i) += (mu * std::tanh(0.5 * mu)).imag() / s2;
    }
    const Eigen::VectorXd moments = slope.partialPivLu().solve(load);
    return simply_supported(s2) - 2.0 * moments.dot(load);
}

}  // namespace palpate::plate::truth
