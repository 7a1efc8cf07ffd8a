#include "host/plate/iterative/jacobi.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/plate/iterative/exchange.hpp"

namespace palpate::plate {
namespace {

constexpr long SWEEPS_PER_CHECK = 32;
constexpr double GROWTH_MAX = 1e6;  ///< of an update over the first

}  // namespace

Jacobi::Jacobi(const Problem& problem, const Options& options, double omega)
    : solid_(require_problem(problem).solid),
      sweeper_(problem, sweep_kernel(options.kernel)),
      options_(options),
      omega_(omega),
      f_(sweeper_.stencil().layout().size(), 0.0),
      x_(f_),
      next_(f_) {}

void Jacobi::set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m) {
    require_rigidity(rigidity_n_m, sweeper_.stencil().layout(), solid_);
    sweeper_.set_rigidity(rigidity_n_m);
}

double Jacobi::residual(double f_max) const {
    return true_residual(sweeper_.stencil(), x_.data(), f_.data(), f_max, next_);
}

Report Jacobi::iterate(double f_max) const {
    const SweepGrid grid = sweeper_.grid();
    const SweepKernel& kernel = sweeper_.kernel();
    const bool by_change = options_.stop == StopRule::change;
    Report report{Status::not_converged, 0, 1.0};
    double first_squared = 0.0;
    while (report.iterations < options_.sweeps_max) {
        kernel.sweep(grid, f_.data(), x_.data(), next_.data(), 1.0, omega_);
        ++report.iterations;
        const bool last = report.iterations == options_.sweeps_max;
        const bool check = last || report.iterations % SWEEPS_PER_CHECK == 0;
        if (report.iterations > 1 && !by_change && !check) {
            std::swap(x_, next_);
            continue;
        }
        const Change change = kernel.change(x_.size(), x_.data(), next_.data());
        std::swap(x_, next_);
        if (report.iterations == 1) first_squared = change.difference_squared;
        if (!(change.difference_squared <= GROWTH_MAX * GROWTH_MAX * first_squared)) {
            report.status = Status::diverged;
            break;
        }
        const double tolerance = options_.tolerance;
        if (by_change ? change.difference_squared < tolerance * tolerance * change.next_squared
                      : check && residual(f_max) <= tolerance) {
            report.status = Status::solved;
            break;
        }
    }
    report.residual = residual(f_max);
    return report;
}

Report Jacobi::solve(std::span<const double> force_n, std::span<double> deflection_m) const {
    const std::lock_guard lock(one_at_a_time_);
    for (auto* const vector : {&f_, &x_, &next_}) std::fill(vector->begin(), vector->end(), 0.0);
    const double f_max = put_force(sweeper_.stencil(), force_n, f_.data());
    const Report report = f_max == 0.0 ? Report{} : iterate(f_max);
    if (report.status == Status::solved)
        require_work(sweeper_.stencil(), x_.data(), f_.data(),
                     name_of(omega_ == PLAIN ? Method::jacobi : Method::damped_jacobi));
    take_deflection(sweeper_.stencil(), x_.data(), deflection_m);
    return report;
}

}  // namespace palpate::plate
