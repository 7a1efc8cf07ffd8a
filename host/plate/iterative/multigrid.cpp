#include "host/plate/iterative/multigrid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "host/plate/iterative/exchange.hpp"

namespace palpate::plate {
namespace {

constexpr long PATIENCE = 50;             ///< iterations without a smaller residual
constexpr double RESTART_GAIN_MIN = 2.0;  ///< of the true residual from one restart to the next

const Problem& coarsenable(const Problem& problem, const Options& options) {
    require_problem(problem);
    if (options.stop == StopRule::change) throw std::invalid_argument("multigrid stops on the residual only");
    const auto nx = problem.rigidity_n_m.rows(), nz = problem.rigidity_n_m.cols();
    if (!can_coarsen(nx, nz)) {
        throw std::invalid_argument("multigrid cannot make a grid of " + std::to_string(nx) + " x " +
                                    std::to_string(nz) +
                                    " nodes coarser; both counts must be odd and at least 9");
    }
    return problem;
}

bool positive(double value) {
    return value > 0.0 && value < std::numeric_limits<double>::infinity();
}

}  // namespace

Multigrid::Multigrid(const Problem& problem, const Options& options)
    : solid_(coarsenable(problem, options).solid),
      options_(options),
      hierarchy_(problem, options.kernel),
      f_(hierarchy_.finest().stencil().layout().size(), 0.0),
      x_(f_),
      r_(f_),
      p_(f_),
      q_(f_),
      z_(f_) {}

void Multigrid::set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m) {
    require_rigidity(rigidity_n_m, hierarchy_.finest().stencil().layout(), solid_);
    hierarchy_.set_rigidity(rigidity_n_m);
}

/// From x = 0, r = f. Begins anew from x whenever the residual that CG carries on is no longer the true one.
Report Multigrid::iterate(double f_max) const {
    const Stencil& stencil = hierarchy_.finest().stencil();
    const SweepKernel& kernel = hierarchy_.finest().kernel();
    const SweepGrid grid = hierarchy_.finest().grid();
    const std::size_t n = f_.size();
    Report report{Status::not_converged, 0, 1.0};
    double rz = 0.0, least = std::numeric_limits<double>::infinity(), restarted_at = 1.0;
    long least_at = 0;
    while (report.iterations < options_.sweeps_max && report.iterations - least_at < PATIENCE) {
        hierarchy_.cycle(r_.data(), z_.data());
        const double before = rz;
        rz = kernel.dot(n, r_.data(), z_.data());
        kernel.add_to(n, z_.data(), before == 0.0 ? 0.0 : rz / before, p_.data());
        const double curvature = kernel.apply(grid, p_.data(), q_.data());
        if (!positive(rz) || !positive(curvature)) {
            report.status = Status::diverged;
            break;
        }
        const double r_max = kernel.step(n, rz / curvature, p_.data(), q_.data(), x_.data(), r_.data());
        ++report.iterations;
        if (r_max < least) {
            least = r_max;
            least_at = report.iterations;
        }
        if (r_max > options_.tolerance * f_max) continue;
        report.residual = true_residual(stencil, x_.data(), f_.data(), f_max, q_);
        if (report.residual <= options_.tolerance || report.residual * RESTART_GAIN_MIN > restarted_at) break;
        restarted_at = report.residual;
        kernel.residual(grid, f_.data(), x_.data(), r_.data());
        rz = 0.0;
    }
    report.residual = true_residual(stencil, x_.data(), f_.data(), f_max, q_);
    if (report.residual <= options_.tolerance) report.status = Status::solved;
    if (!std::isfinite(report.residual)) report.status = Status::diverged;
    return report;
}

Report Multigrid::solve(std::span<const double> force_n, std::span<double> deflection_m) const {
    const std::lock_guard lock(one_at_a_time_);
    const Stencil& stencil = hierarchy_.finest().stencil();
    for (auto* const vector : {&f_, &x_, &p_}) std::fill(vector->begin(), vector->end(), 0.0);
    const double f_max = put_force(stencil, force_n, f_.data());
    std::copy(f_.begin(), f_.end(), r_.begin());
    const Report report = f_max == 0.0 ? Report{} : iterate(f_max);
    if (report.status == Status::solved)
        require_work(stencil, x_.data(), f_.data(), name_of(Method::multigrid));
    take_deflection(stencil, x_.data(), deflection_m);
    return report;
}

}  // namespace palpate::plate
