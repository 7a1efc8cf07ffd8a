#include "host/plate/iterative/eq7.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <vector>

#include "host/plate/iterative/exchange.hpp"

namespace palpate::plate {
namespace {

using Eigen::ArrayXXd;
using Eigen::Index;
using Triplets = std::vector<Eigen::Triplet<double>>;

constexpr double STEP_MAX = 1.8;         ///< of D from a node to its eight neighbours
constexpr double ENERGY_GAP_MAX = 0.02;  ///< of the energy form's strain energy from the forces' work

const Problem& solvable(const Problem& problem) {
    const auto refuse = [](const std::string& words) { throw std::invalid_argument("eq7: " + words); };
    require_problem(problem);
    for (const Edge edge : problem.edges) {
        if (edge != Edge::clamped) refuse("all edges must be clamped");
    }
    if (problem.poisson_at_nodes.size() != 0) refuse("Poisson's ratio must be the same everywhere");
    if (problem.lines_x_m.size() != 0 || problem.lines_z_m.size() != 0)
        refuse("grid lines must be evenly spaced");
    if (problem.solid.size() != 0) refuse("there must be plate everywhere");
    if (problem.harmonic_x_n_m.size() != 0) refuse("no rule for jumps of D on grid lines");
    return problem;
}

/// Largest ratio of D between a node and one of its eight neighbours.
double step_of(const ArrayXXd& d) {
    double most = 1.0;
    const auto take = [&](double a, double b) { most = std::max({most, a / b, b / a}); };
    for (Index iz = 0; iz < d.cols(); ++iz) {
        for (Index ix = 0; ix < d.rows(); ++ix) {
            const bool right = ix + 1 < d.rows(), up = iz + 1 < d.cols();
            if (right) take(d(ix, iz), d(ix + 1, iz));
            if (up) take(d(ix, iz), d(ix, iz + 1));
            if (!right || !up) continue;
            take(d(ix, iz), d(ix + 1, iz + 1));
            take(d(ix + 1, iz), d(ix, iz + 1));
        }
    }
    return most;
}

/// One row of the matrix in the making: the equation at one node.
struct Row {
    Index nx, nz;
    double hx, hz;
    int number;
    Triplets* entries;

    /// Adds c w at a node; edges do not move, nodes beyond them mirror.
    void w(Index ix, Index iz, double c) const {
        const auto mirrored = [](Index i, Index n) { return i < 0 ? -i : (i >= n ? 2 * (n - 1) - i : i); };
        const Index x = mirrored(ix, nx), z = mirrored(iz, nz);
        if (x == 0 || z == 0 || x == nx - 1 || z == nz - 1) return;
        entries->emplace_back(number, static_cast<int>(x - 1 + (z - 1) * (nx - 2)), c);
    }
    void w_xx(Index ix, Index iz, double c) const {
        w(ix - 1, iz, c / (hx * hx));
        w(ix, iz, -2.0 * c / (hx * hx));
        w(ix + 1, iz, c / (hx * hx));
    }
    void w_zz(Index ix, Index iz, double c) const {
        w(ix, iz - 1, c / (hz * hz));
        w(ix, iz, -2.0 * c / (hz * hz));
        w(ix, iz + 1, c / (hz * hz));
    }
    void w_xz(Index ix, Index iz, double c) const {
        const double each = c / (4.0 * hx * hz);
        w(ix + 1, iz + 1, each);
        w(ix + 1, iz - 1, -each);
        w(ix - 1, iz + 1, -each);
        w(ix - 1, iz - 1, each);
    }
    void lap(Index ix, Index iz, double c) const {
        w_xx(ix, iz, c);
        w_zz(ix, iz, c);
    }
};

/// The equation at an inner node, times hx hz, D as given.
void add_equation(const Row& row, Index i, Index j, const ArrayXXd& d, double poisson) {
    const double hx = row.hx, hz = row.hz, area = hx * hz;
    const double d_x = (d(i + 1, j) - d(i - 1, j)) / (2.0 * hx);
    const double d_z = (d(i, j + 1) - d(i, j - 1)) / (2.0 * hz);
    const double d_xx = (d(i + 1, j) - 2.0 * d(i, j) + d(i - 1, j)) / (hx * hx);
    const double d_zz = (d(i, j + 1) - 2.0 * d(i, j) + d(i, j - 1)) / (hz * hz);
    const double d_xz =
        (d(i + 1, j + 1) - d(i + 1, j - 1) - d(i - 1, j + 1) + d(i - 1, j - 1)) / (4.0 * hx * hz);
    const double by_x = d(i, j) / (hx * hx), by_z = d(i, j) / (hz * hz);
    row.lap(i + 1, j, area * (by_x + d_x / hx));
    row.lap(i - 1, j, area * (by_x - d_x / hx));
    row.lap(i, j + 1, area * (by_z + d_z / hz));
    row.lap(i, j - 1, area * (by_z - d_z / hz));
    row.lap(i, j, area * (d_xx + d_zz - 2.0 * (by_x + by_z)));
    row.w_zz(i, j, -area * (1.0 - poisson) * d_xx);
    row.w_xz(i, j, 2.0 * area * (1.0 - poisson) * d_xz);
    row.w_xx(i, j, -area * (1.0 - poisson) * d_zz);
}

}  // namespace

Eq7::Eq7(const Problem& problem)
    : stencil_(solvable(problem)),
      step_(1.0 / static_cast<double>(problem.rigidity_n_m.rows() - 1),
            problem.size_m.y() / problem.size_m.x() / static_cast<double>(problem.rigidity_n_m.cols() - 1)),
      poisson_(problem.poisson),
      foundation_n_per_m3_(problem.foundation_n_per_m3) {
    factorise(problem.rigidity_n_m);
}

void Eq7::set_rigidity(const Eigen::Ref<const ArrayXXd>& rigidity_n_m) {
    require_rigidity(rigidity_n_m, stencil_.layout(), {});
    stencil_.set_rigidity(rigidity_n_m);
    factorise(rigidity_n_m);
}

void Eq7::factorise(const Eigen::Ref<const ArrayXXd>& rigidity_n_m) {
    const Index nx = rigidity_n_m.rows(), nz = rigidity_n_m.cols();
    const ArrayXXd d = rigidity_n_m / rigidity_n_m.maxCoeff();
    step_max_ = step_of(d);
    const double area_m2 = step_.x() * step_.y() * stencil_.side_m() * stencil_.side_m();
    Triplets entries;
    for (Index j = 1; j + 1 < nz; ++j) {
        for (Index i = 1; i + 1 < nx; ++i) {
            const int number = static_cast<int>(i - 1 + (j - 1) * (nx - 2));
            add_equation({nx, nz, step_.x(), step_.y(), number, &entries}, i, j, d, poisson_);
            if (foundation_n_per_m3_.size() == 0) continue;
            entries.emplace_back(number, number,
                                 area_m2 * foundation_n_per_m3_(i, j) * stencil_.compliance_m_per_n());
        }
    }
    const Index n = (nx - 2) * (nz - 2);
    matrix_.resize(n, n);
    matrix_.setFromTriplets(entries.begin(), entries.end());
    lu_.compute(matrix_);
    require_factor();
}

void Eq7::require_factor() const {
    if (lu_.info() != Eigen::Success) throw Guard("eq7: the matrix is singular");
}

/// Neither test alone tells: a stiff wrong answer may have the energy of its own work.
void Eq7::require_trust(const std::vector<double>& x, const std::vector<double>& f) const {
    std::vector<double> kx(x.size(), 0.0);
    stencil_.apply(x.data(), kx.data());
    const double work = std::inner_product(x.begin(), x.end(), f.begin(), 0.0);
    const double gap = std::fabs(std::inner_product(x.begin(), x.end(), kx.begin(), 0.0) / work - 1.0);
    if (work == 0.0 || (step_max_ <= STEP_MAX && gap <= ENERGY_GAP_MAX)) return;
    std::array<char, 200> words;
    std::snprintf(
        words.data(), words.size(),
        "eq7 cannot be trusted: D changes %.3g-fold between neighbours (at most %.3g), strain energy "
        "%.3g %% off (at most %.3g %%); the work of the forces is %.9g",
        step_max_, STEP_MAX, 100.0 * gap, 100.0 * ENERGY_GAP_MAX, work * stencil_.compliance_m_per_n());
    throw Guard(words.data());
}

Report Eq7::solve(std::span<const double> force_n, std::span<double> deflection_m) const {
    require_factor();
    const Layout& layout = stencil_.layout();
    const Moving& moving = stencil_.moving();
    std::vector<double> f(layout.size(), 0.0), x(f);
    const double f_max = put_force(stencil_, force_n, f.data());
    const Index n = layout.nx - 2;
    Eigen::VectorXd load(moving.count());
    const auto row_of = [&](std::vector<double>& v, Index iz) {
        return Eigen::Map<Eigen::VectorXd>(v.data() + layout.at(1, iz), n);
    };
    for (Index iz = moving.z0; iz < moving.z1; ++iz) load.segment((iz - 1) * n, n) = row_of(f, iz);
    const Eigen::VectorXd w = lu_.solve(load);
    for (Index iz = moving.z0; iz < moving.z1; ++iz) row_of(x, iz) = w.segment((iz - 1) * n, n);
    const Eigen::VectorXd off = matrix_ * w - load;
    const Report report{
        Status::solved, 0,
        f_max == 0.0 ? 0.0 : largest({off.data(), static_cast<std::size_t>(off.size())}) / f_max};
    if (!(report.residual <= RESIDUAL_MAX)) throw Guard("eq7: the solution leaves a residual above 1e-7");
    require_work(stencil_, x.data(), f.data(), name_of(Method::eq7));
    require_trust(x, f);
    take_deflection(stencil_, x.data(), deflection_m);
    return report;
}

}  // namespace palpate::plate
