#include <algorithm>
#include <cmath>
#include <string>

#include "host/plate/coarser.hpp"
#include "host/plate/plate.hpp"
#include "host/plate/uniform/uniform.hpp"

namespace palpate::plate {
namespace {

using Eigen::Index;

constexpr double TABLE_ERROR = 1e-6;  ///< of the uniform plate's values, with a margin

/// Half the distance between a line's neighbours: the spacing there.
double spacing_m(const Eigen::ArrayXd& lines_m, Index n, double length_m, Index i) {
    if (lines_m.size() == 0) return length_m / static_cast<double>(n - 1);
    return 0.5 * (lines_m(i + 1) - lines_m(i - 1));
}

/// The uniform square that stands for the plate around the load: same spacing, same D and k_f.
struct Local {
    Index n;               ///< nodes on a side
    double scale_m_per_n;  ///< side^2/D
    double side_over_l;

    Local(const Problem& problem, const Node& load)
        : n(std::min(problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols()) | 1) {
        const double hx_m =
            spacing_m(problem.lines_x_m, problem.rigidity_n_m.rows(), problem.size_m.x(), load.ix);
        const double hz_m =
            spacing_m(problem.lines_z_m, problem.rigidity_n_m.cols(), problem.size_m.y(), load.iz);
        const double side_m = static_cast<double>(n - 1) * std::sqrt(0.5 * (hx_m * hx_m + hz_m * hz_m));
        const double rigidity = problem.rigidity_n_m(load.ix, load.iz);
        const bool held = problem.foundation_n_per_m3.size() != 0;
        const double foundation = held ? problem.foundation_n_per_m3(load.ix, load.iz) : 0.0;
        scale_m_per_n = side_m * side_m / rigidity;
        side_over_l = side_m * std::sqrt(std::sqrt(foundation / rigidity));
    }
};

/// Compliance on a grid, less the grid error of the local uniform plate there (MATH.md eq. 8).
double corrected(const Problem& problem, const Node& load) {
    return Plate(problem).compliance_m_per_n(load) - local_grid_error_m_per_n(problem, load);
}

double richardson(double on_fine, double on_coarse) {
    return (4.0 * on_fine - on_coarse) / 3.0;
}

/// What a count or the load's place in it must be for another, coarser grid: 4 m + 1 nodes, an even line.
bool halves(Index n, Index line) {
    return n >= 9 && n % 4 == 1 && line % 2 == 0;
}

void require_grid(const Problem& problem, const Node& load) {
    require_problem(problem);
    const Index nx = problem.rigidity_n_m.rows();
    const Index nz = problem.rigidity_n_m.cols();
    if (!halves(nx, 0) || !halves(nz, 0)) {
        throw std::invalid_argument("grid of " + std::to_string(nx) + " x " + std::to_string(nz) +
                                    " nodes; each count must be 4 m + 1 and at least 9");
    }
    const auto inside = [](Index i, Index n) { return i >= 2 && i + 2 < n && i % 2 == 0; };
    if (inside(load.ix, nx) && inside(load.iz, nz)) return;
    throw std::invalid_argument("load at node (" + std::to_string(load.ix) + ", " + std::to_string(load.iz) +
                                "); both must be even, and two nodes from the edge");
}

}  // namespace

double local_grid_error_m_per_n(const Problem& problem, const Node& load) {
    const Local local(problem, load);
    return local.scale_m_per_n * (uniform_square_grid_compliance(local.n, local.side_over_l) -
                                  uniform_square_compliance(local.side_over_l));
}

Estimate extrapolated_compliance(const Problem& fine, const Node& load) {
    require_grid(fine, load);
    const Problem coarse = every_second_node(fine);
    const Node half{load.ix / 2, load.iz / 2};
    const double on_fine = corrected(fine, load);
    const double on_coarse = corrected(coarse, half);
    const double result = richardson(on_fine, on_coarse);
    if (!(result > 0.0))
        throw Guard("extrapolated compliance is not positive; the grid is too coarse for the plate");

    const double step = std::fabs(result - on_fine);
    double error = 2.0 * step;
    const bool third_grid =
        halves(coarse.rigidity_n_m.rows(), half.ix) && halves(coarse.rigidity_n_m.cols(), half.iz);
    if (third_grid && !has_jump(fine.rigidity_n_m)) {
        const Node quarter{half.ix / 2, half.iz / 2};
        const double on_coarsest = corrected(every_second_node(coarse), quarter);
        error = std::max(std::fabs(result - richardson(on_coarse, on_coarsest)) / 4.0, step / 16.0);
    }
    return {result, error / result + TABLE_ERROR};
}

Estimate extrapolated_centre_compliance(const Problem& fine) {
    return extrapolated_compliance(fine, {fine.rigidity_n_m.rows() / 2, fine.rigidity_n_m.cols() / 2});
}

}  // namespace palpate::plate
