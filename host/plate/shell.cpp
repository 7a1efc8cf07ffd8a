#include "host/plate/shell.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "host/plate/plate.hpp"

namespace palpate::plate {
namespace {

using Eigen::ArrayXXd;
using Eigen::Index;

constexpr std::size_t N_DIRECTIONS = 8;  // in the quarter between the principal ones, at midpoints
constexpr double SIGMA_OVER_L = 2.0;
constexpr double BOUNDARY_SHARE_MIN = 0.01;  // of the compliance, below which an edge does not dominate

double fourth_power(double x) {
    return x * x * x * x;
}

/// a/l of the uniform clamped square that gives way by `compliance` (side 1, D = 1); between the bounds.
double side_over_l_with(double compliance, double stiffest, double softest) {
    double high = stiffest, low = softest;
    for (int k = 0; k < 60 && low < high; ++k) {
        const double middle = 0.5 * (low + high);
        (uniform_square_compliance(middle) > compliance ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

struct Curved {
    double curvature2_per_m2;  ///< k_f = E h curvature2
    bool boundary_dominated;
};

/// `slender` = 12 (1 - nu^2) a^4/h^2: (a/l)^4 = slender curvature2.

Curved effective_curvature(const Shell& shell, double slender) {
    const double gauss = std::max(shell.kappa1_per_m * shell.kappa2_per_m, 0.0);
    std::array<double, N_DIRECTIONS> sides_over_l{};
    double mean = 0.0;
    for (std::size_t k = 0; k < N_DIRECTIONS; ++k) {
        const double t = 0.5 * std::numbers::pi * (static_cast<double>(k) + 0.5) / N_DIRECTIONS;
        const double c2 = std::cos(t) * std::cos(t);
        const double across = shell.kappa2_per_m * c2 + shell.kappa1_per_m * (1.0 - c2);
        sides_over_l[k] = std::pow(slender * across * across, 0.25);
        mean += uniform_square_compliance(sides_over_l[k]) / static_cast<double>(N_DIRECTIONS);
    }
    const auto [softest, stiffest] = std::minmax_element(sides_over_l.begin(), sides_over_l.end());
    const double by_mean = fourth_power(side_over_l_with(mean, *stiffest, *softest)) / slender;
    const double endless = uniform_square_compliance(std::pow(slender * gauss, 0.25));
    return {by_mean, mean < (1.0 - BOUNDARY_SHARE_MIN) * endless};
}

/// Gaussian weights between the nodes of one axis; rows need not add up to 1.
Eigen::MatrixXd gaussian(Index n, double size_m, double sigma_m) {
    const double step = size_m / static_cast<double>(n - 1) / sigma_m;
    Eigen::MatrixXd weights(n, n);
    for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < n; ++j) {
            const double apart = step * static_cast<double>(i - j);
            weights(i, j) = std::exp(-0.5 * apart * apart);
        }
    }
    return weights;
}

/// Harmonic Gaussian mean of E over the skin; 0 where there is none. A constant comes back to the bit.
ArrayXXd smoothed(const ArrayXXd& young_pa, const Eigen::Vector2d& size_m, double sigma_m) {
    const double unit_pa = young_pa(young_pa.rows() / 2, young_pa.cols() / 2);
    const auto skin = young_pa > 0.0;
    const Eigen::MatrixXd softness = skin.select(unit_pa / young_pa - 1.0, 0.0);
    const Eigen::MatrixXd there = skin.select(ArrayXXd::Ones(young_pa.rows(), young_pa.cols()), 0.0);
    const Eigen::MatrixXd along_x = gaussian(young_pa.rows(), size_m.x(), sigma_m);
    const Eigen::MatrixXd along_z = gaussian(young_pa.cols(), size_m.y(), sigma_m);
    const ArrayXXd sum = (along_x * softness * along_z).array();
    const ArrayXXd weight = (along_x * there * along_z).array();
    return skin.select(unit_pa / (1.0 + sum / weight), 0.0);
}

void require(bool holds, const char* words) {
    if (!holds) throw std::invalid_argument(words);
}

void require_usable(const Shell& shell, const ArrayXXd& young_pa, const ArrayXXd& thickness_m, double poisson,
                    const Eigen::Vector2d& size_m) {
    const Index nx = young_pa.rows(), nz = young_pa.cols();
    require(nx >= 3 && nz >= 3 && nx % 2 == 1 && nz % 2 == 1, "a shell's node counts must be odd");
    require(young_pa.allFinite() && young_pa.minCoeff() >= 0.0 && young_pa(nx / 2, nz / 2) > 0.0,
            "Young's modulus must not be negative, and positive at the centre");
    require(thickness_m.size() == 1 || (thickness_m.rows() == nx && thickness_m.cols() == nz),
            "thickness: one, or one at each node");
    require(thickness_m.allFinite() && thickness_m.minCoeff() > 0.0, "thickness must be positive");
    require(poisson > -1.0 && poisson < 0.5, "Poisson's ratio must lie between -1 and 0.5");
    require(size_m.allFinite() && size_m.minCoeff() > 0.0, "sides must be positive");
    require(std::isfinite(shell.kappa1_per_m) && std::isfinite(shell.kappa2_per_m),
            "curvature must be finite");
}

}  // namespace

ShellTerm shell_term(const Shell& shell, const ArrayXXd& young_pa, const ArrayXXd& thickness_m,
                     double poisson, const Eigen::Vector2d& size_m) {
    require_usable(shell, young_pa, thickness_m, poisson, size_m);
    const Index nx = young_pa.rows(), nz = young_pa.cols();
    const bool even = thickness_m.size() == 1;
    const double h_m = even ? thickness_m(0, 0) : thickness_m(nx / 2, nz / 2);
    const double per_h2 = 12.0 * (1.0 - poisson * poisson) / (h_m * h_m);
    const double area_m2 = size_m.x() * size_m.y();  // of the square that stands for the patch
    const Curved curved = effective_curvature(shell, area_m2 * area_m2 * per_h2);
    if (!(curved.curvature2_per_m2 > 0.0)) {
        return {ArrayXXd::Zero(nx, nz), curved.boundary_dominated, std::numeric_limits<double>::infinity()};
    }
    // l of the local E: from the smoothed one c would be 3-7 % higher at warts, no nearer to the shell's.
    const double l_m = std::pow(per_h2 * curved.curvature2_per_m2, -0.25);
    ShellTerm term{smoothed(young_pa, size_m, SIGMA_OVER_L * l_m), curved.boundary_dominated, l_m};
    term.foundation_n_per_m3 *= curved.curvature2_per_m2;
    if (even) {
        term.foundation_n_per_m3 *= h_m;
    } else {
        term.foundation_n_per_m3 *= thickness_m;
    }
    return term;
}

}  // namespace palpate::plate
