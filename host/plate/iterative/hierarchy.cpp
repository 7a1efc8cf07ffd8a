#include "host/plate/iterative/hierarchy.hpp"

#include <algorithm>

namespace palpate::plate {
namespace {

using Eigen::Index;

/// Chebyshev's interval is [bound/INTERVAL, bound]: errors of twice the spacing have 1/16 of the largest
/// eigenvalue.
constexpr double INTERVAL = 14.0;

Eigen::ArrayXd every_second(const Eigen::ArrayXd& lines_m) {
    if (lines_m.size() == 0) return {};
    return lines_m(Eigen::seq(0, lines_m.size() - 1, 2));
}

Eigen::ArrayXXd weighed(const Eigen::ArrayXXd& fine) {
    if (fine.size() == 0) return {};
    Eigen::ArrayXXd coarse(coarser(fine.rows()), coarser(fine.cols())), room(fine.rows(), fine.cols());
    weigh_fully(fine, coarse, room);
    return coarse;
}

/// D and foundation everywhere, next to nothing where there is no plate.
Problem without_mask(Problem problem) {
    if (problem.solid.size() == 0) return problem;
    const double most = problem.solid.select(problem.rigidity_n_m, 0.0).maxCoeff();
    problem.rigidity_n_m = problem.solid.select(problem.rigidity_n_m, FREE_EDGE * most).eval();
    if (problem.foundation_n_per_m3.size() != 0)
        problem.foundation_n_per_m3 = problem.solid.select(problem.foundation_n_per_m3, 0.0).eval();
    problem.solid.resize(0, 0);
    return problem;
}

/// Without mask and jumps.
Problem coarsened(const Problem& fine) {
    Problem coarse;
    coarse.size_m = fine.size_m;
    coarse.rigidity_n_m = weighed(fine.rigidity_n_m);
    coarse.foundation_n_per_m3 = weighed(fine.foundation_n_per_m3);
    coarse.poisson = fine.poisson;
    coarse.edges = fine.edges;
    coarse.poisson_at_nodes = weighed(fine.poisson_at_nodes);
    coarse.lines_x_m = every_second(fine.lines_x_m);
    coarse.lines_z_m = every_second(fine.lines_z_m);
    return coarse;
}

}  // namespace

Hierarchy::Level::Level(const Problem& problem, const SweepKernel& kernel)
    : sweeper(problem, kernel),
      rigidity_n_m(problem.rigidity_n_m),
      room(problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols()),
      f(sweeper.stencil().layout().size(), 0.0),
      x(f),
      other(f),
      r(f) {}

/// Chebyshev's iteration on [low, bound], its first two steps.
void Hierarchy::Level::set_smoother() {
    const double bound = sweeper.eigenvalue_bound(), low = bound / INTERVAL;
    const double middle = 0.5 * (bound + low), half = 0.5 * (bound - low);
    const double rho = half / middle;
    const double next_rho = 1.0 / (2.0 * middle / half - rho);
    first = 1.0 / middle;
    momentum = next_rho * rho;
    second = 2.0 * next_rho / half;
}

void Hierarchy::Level::smooth_from_zero(const double* rhs, double* to) {
    const SweepGrid grid = sweeper.grid();
    sweeper.kernel().start(grid, rhs, other.data(), first);
    sweeper.kernel().sweep(grid, rhs, other.data(), to, 1.0 + momentum, second);
}

void Hierarchy::Level::smooth(const double* rhs, double* at) {
    const SweepGrid grid = sweeper.grid();
    sweeper.kernel().sweep(grid, rhs, at, other.data(), 1.0, first);
    sweeper.kernel().sweep_on(grid, rhs, other.data(), at, momentum, second);
}

Hierarchy::Hierarchy(const Problem& problem, Kernel kernel) : solid_(problem.solid) {
    levels_.emplace_back(problem, sweep_kernel(kernel));
    Problem next = without_mask(problem);
    levels_.front().rigidity_n_m = next.rigidity_n_m;
    while (can_coarsen(next.rigidity_n_m.rows(), next.rigidity_n_m.cols())) {
        next = coarsened(next);
        levels_.emplace_back(next, sweep_kernel(kernel));
        transfers_.emplace_back(levels_[levels_.size() - 2].sweeper.stencil().layout(),
                                levels_.back().sweeper.stencil().layout(), problem.edges);
    }
    coarsest_.emplace(next, kernel);
    coarsest_force_n_.assign(static_cast<std::size_t>(next.rigidity_n_m.size()), 0.0);
    coarsest_deflection_m_ = coarsest_force_n_;
    refresh();
}

void Hierarchy::set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m) {
    Eigen::ArrayXXd& finest = levels_.front().rigidity_n_m;
    finest = rigidity_n_m;
    if (solid_.size() != 0) {
        const double most = solid_.select(rigidity_n_m, 0.0).maxCoeff();
        finest = solid_.select(rigidity_n_m, FREE_EDGE * most);
    }
    levels_.front().sweeper.set_rigidity(finest);
    for (std::size_t i = 1; i < levels_.size(); ++i) {
        weigh_fully(levels_[i - 1].rigidity_n_m, levels_[i].rigidity_n_m, levels_[i - 1].room);
        levels_[i].sweeper.set_rigidity(levels_[i].rigidity_n_m);
    }
    coarsest_->set_rigidity(levels_.back().rigidity_n_m);
    refresh();
}

void Hierarchy::refresh() {
    for (std::size_t i = 0; i < levels_.size(); ++i) {
        levels_[i].set_smoother();
        if (i == 0) continue;
        levels_[i].scale = levels_[i].sweeper.stencil().compliance_m_per_n() /
                           levels_[i - 1].sweeper.stencil().compliance_m_per_n();
    }
}

void Hierarchy::cycle(const double* f, double* x) {
    descend(0, f, x);
}

void Hierarchy::solve_coarsest(const double* f, double* x) {
    const Stencil& stencil = levels_.back().sweeper.stencil();
    const Layout& layout = stencil.layout();
    const Moving& moving = stencil.moving();
    const auto for_moving = [&](auto&& visit) {
        for (Index iz = moving.z0; iz < moving.z1; ++iz) {
            for (Index ix = moving.x0; ix < moving.x1; ++ix)
                visit(static_cast<std::size_t>(ix + layout.nx * iz), layout.at(ix, iz));
        }
    };
    for_moving([&](std::size_t node, std::size_t at) { coarsest_force_n_[node] = f[at]; });
    coarsest_->solve(coarsest_force_n_, coarsest_deflection_m_);
    const double per_m = 1.0 / stencil.compliance_m_per_n();
    for_moving([&](std::size_t node, std::size_t at) { x[at] = coarsest_deflection_m_[node] * per_m; });
}

void Hierarchy::descend(std::size_t level, const double* f, double* x) {
    if (level + 1 == levels_.size()) {
        solve_coarsest(f, x);
        return;
    }
    Level& here = levels_[level];
    Level& below = levels_[level + 1];
    here.smooth_from_zero(f, x);
    here.sweeper.kernel().residual(here.sweeper.grid(), f, x, here.r.data());
    transfers_[level].restrict_from(here.r.data(), below.scale, below.f.data());
    descend(level + 1, below.f.data(), below.x.data());
    transfers_[level].prolong(below.x.data(), x);
    here.smooth(f, x);
}

}  // namespace palpate::plate
