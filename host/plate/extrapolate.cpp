#include <algorithm>
#include <cmath>
#include <string>

#include "host/plate/plate.hpp"
#include "host/plate/uniform.hpp"

namespace palpate::plate {
namespace {

using Eigen::Index;

constexpr double TABLE_ERROR = 1e-6;  ///< of the uniform plate's values, with a margin

/// Every second node.
Eigen::ArrayXXd thinned(const Eigen::ArrayXXd& field) {
    if (field.size() == 0) return field;
    Eigen::ArrayXXd coarse((field.rows() + 1) / 2, (field.cols() + 1) / 2);
    for (Index ix = 0; ix < coarse.rows(); ++ix) {
        for (Index iz = 0; iz < coarse.cols(); ++iz) coarse(ix, iz) = field(2 * ix, 2 * iz);
    }
    return coarse;
}

Problem thinned(const Problem& fine) {
    return {fine.size_m, thinned(fine.rigidity_n_m), thinned(fine.foundation_n_per_m3), fine.poisson};
}

/// The uniform square that stands for the plate around its centre: same spacing, same D and k_f.
struct Local {
    Index n;               ///< nodes on a side
    double scale_m_per_n;  ///< side^2/D
    double side_over_l;

    explicit Local(const Problem& problem)
        : n(std::min(problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols())) {
        const Index nx = problem.rigidity_n_m.rows();
        const Index nz = problem.rigidity_n_m.cols();
        const double hx_m = problem.size_m.x() / static_cast<double>(nx - 1);
        const double hz_m = problem.size_m.y() / static_cast<double>(nz - 1);
        const double side_m = static_cast<double>(n - 1) * std::sqrt(0.5 * (hx_m * hx_m + hz_m * hz_m));
        const double rigidity = problem.rigidity_n_m(nx / 2, nz / 2);
        const bool held = problem.foundation_n_per_m3.size() != 0;
        const double foundation = held ? problem.foundation_n_per_m3(nx / 2, nz / 2) : 0.0;
        scale_m_per_n = side_m * side_m / rigidity;
        side_over_l = side_m * std::sqrt(std::sqrt(foundation / rigidity));
    }
};

/// Compliance on a grid, less the grid error of the local uniform plate there (MATH.md eq. 8).
double corrected(const Problem& problem, const Local& local, Index n) {
    const double error =
        uniform_square_grid_compliance(n, local.side_over_l) - uniform_square_compliance(local.side_over_l);
    return Plate(problem).centre_compliance_m_per_n() - error * local.scale_m_per_n;
}

double richardson(double on_fine, double on_coarse) {
    return (4.0 * on_fine - on_coarse) / 3.0;
}

/// More than a factor of 2 between neighbours: the order of the method is lost (MATH.md eq. 10).
bool has_jump(const Eigen::ArrayXXd& rigidity) {
    const auto jumps = [](double a, double b) { return a > 2.0 * b || b > 2.0 * a; };
    for (Index ix = 0; ix < rigidity.rows(); ++ix) {
        for (Index iz = 0; iz < rigidity.cols(); ++iz) {
            if (ix > 0 && jumps(rigidity(ix, iz), rigidity(ix - 1, iz))) return true;
            if (iz > 0 && jumps(rigidity(ix, iz), rigidity(ix, iz - 1))) return true;
        }
    }
    return false;
}

void require_grid(const Problem& problem) {
    if (const auto problem_text = problem_with(problem)) throw std::invalid_argument(*problem_text);
    const Index nx = problem.rigidity_n_m.rows();
    const Index nz = problem.rigidity_n_m.cols();
    if (nx >= 9 && nz >= 9 && nx % 4 == 1 && nz % 4 == 1) return;
    throw std::invalid_argument("grid of " + std::to_string(nx) + " x " + std::to_string(nz) +
                                " nodes; each count must be 4 m + 1 and at least 9");
}

}  // namespace

Compliance extrapolated_centre_compliance(const Problem& fine) {
    require_grid(fine);
    const Local local(fine);
    const Problem coarse = thinned(fine);
    const double on_fine = corrected(fine, local, local.n);
    const double on_coarse = corrected(coarse, local, (local.n + 1) / 2);
    const double result = richardson(on_fine, on_coarse);
    if (!(result > 0.0))
        throw Guard("extrapolated compliance is not positive; the grid is too coarse for the plate");

    const double step = std::fabs(result - on_fine);
    double error = 2.0 * step;
    const auto halves = [](Index n) { return n % 4 == 1 && n >= 9; };  // to a grid of 5 nodes at least
    const bool third_grid = halves(coarse.rigidity_n_m.rows()) && halves(coarse.rigidity_n_m.cols());
    if (third_grid && !has_jump(fine.rigidity_n_m)) {
        const double on_coarsest = corrected(thinned(coarse), local, (local.n + 3) / 4);
        error = std::max(std::fabs(result - richardson(on_coarse, on_coarsest)) / 4.0, step / 16.0);
    }
    return {result, error / result + TABLE_ERROR};
}

}  // namespace palpate::plate
