// The paper's iteration and multigrid against the direct method, from a new D to an answer, call by call in
// turn.
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/plate/iterative/jacobi.hpp"
#include "host/plate/iterative/sweeper.hpp"
#include "host/plate/plate.hpp"
#include "host/plate/solver.hpp"
#include "tests/bench/measure.hpp"
#include "tests/host/plate/fields.hpp"

namespace palpate::bench {
namespace {

using Eigen::Index;
using plate::Kernel;
using plate::Problem;

constexpr double AGREE = 1e-5;  // a method that is wrong would be no competitor

/// Damped Jacobi's sweeps to an error of 1e-3 of the uniform clamped square under a point load at its centre.
/// They are counted, not run: 65 nodes would take 15 s. Test "damped Jacobi needs the known number of sweeps
/// ..." counts the like.
struct Count {
    Index n;
    double sweeps;
};

/// Times of sweeps without any stop rule, which would cost more, and of the direct method, of the same D.
void jacobi(benchmark::State& state, const Count& count, Kernel kernel) {
    constexpr int N_SWEEPS = 200;
    const Problem problem = plate::fields::unit_square(count.n, plate::fields::one);
    plate::Plate direct(problem, kernel);
    plate::Sweeper sweeper(problem, plate::sweep_kernel(kernel));
    const plate::Layout& layout = sweeper.stencil().layout();
    std::vector<double> f(layout.size(), 0.0), x(f), next(f), sweep_s, direct_s;
    f[layout.at(count.n / 2, count.n / 2)] = 1.0;
    for (auto _ : state) {
        sweep_s.push_back(timed_s(Clock::cpu,
                                  [&] {
                                      for (int k = 0; k < N_SWEEPS; ++k) {
                                          sweeper.kernel().sweep(sweeper.grid(), f.data(), x.data(),
                                                                 next.data(), 1.0, plate::Jacobi::DAMPED);
                                          std::swap(x, next);
                                      }
                                  }) /
                          N_SWEEPS);
        direct_s.push_back(timed_s(Clock::cpu, [&] {
            direct.set_rigidity(problem.rigidity_n_m);
            benchmark::DoNotOptimize(direct.centre_compliance_m_per_n());
        }));
        state.SetIterationTime(direct_s.back());
    }
    const double per_sweep_s = quantile(sweep_s, 0.5), once_s = quantile(direct_s, 0.5);
    state.counters["direct_s"] = once_s;
    state.counters["jacobi_s"] = per_sweep_s * count.sweeps;
    state.counters["jacobi_ratio"] = per_sweep_s * count.sweeps / once_s;
    state.counters["sweep_s_per_node"] = per_sweep_s / static_cast<double>(count.n * count.n);
}

/// Both to the deflection everywhere, D of contrast 10, multigrid to a residual.
void multigrid(benchmark::State& state, Index n, double tolerance, Kernel kernel) {
    const Problem problem = plate::fields::unit_square(n, plate::fields::hyper10);
    const auto direct = make_solver(plate::Method::cholesky, problem, {.kernel = kernel});
    const auto iterative =
        make_solver(plate::Method::multigrid, problem, {.tolerance = tolerance, .kernel = kernel});
    const auto n_nodes = static_cast<std::size_t>(n * n);
    std::vector<double> force_n(n_nodes, 0.0), by_direct_m(n_nodes), by_multigrid_m(n_nodes), direct_s,
        multigrid_s;
    force_n[n_nodes / 2] = 1.0;
    plate::Report report;
    for (auto _ : state) {
        multigrid_s.push_back(timed_s(Clock::cpu, [&] {
            iterative->set_rigidity(problem.rigidity_n_m);
            report = iterative->solve(force_n, by_multigrid_m);
        }));
        direct_s.push_back(timed_s(Clock::cpu, [&] {
            direct->set_rigidity(problem.rigidity_n_m);
            static_cast<void>(direct->solve(force_n, by_direct_m));
        }));
        state.SetIterationTime(multigrid_s.back());
    }
    const double off = std::fabs(by_multigrid_m[n_nodes / 2] / by_direct_m[n_nodes / 2] - 1.0);
    if (report.status != plate::Status::solved || !(off < AGREE))
        throw std::runtime_error("multigrid: the two sides do not agree");
    state.counters["multigrid_s"] = quantile(multigrid_s, 0.5);
    state.counters["direct_s"] = quantile(direct_s, 0.5);
    state.counters["direct_ratio"] = quantile(direct_s, 0.5) / quantile(multigrid_s, 0.5);
    state.counters["iterations"] = static_cast<double>(report.iterations);
    state.counters["error_centre"] = off;
}

}  // namespace

void register_jacobi() {
    for (const Kernel kernel : {Kernel::portable, Kernel::best}) {
        const std::string name = kernel == Kernel::best ? ", best kernels" : ", portable";
        for (const Count& count : {Count{17, 11687}, Count{33, 182006}, Count{65, 2891900}}) {
            add("jacobi/" + std::to_string(count.n) + " nodes, to an error of 1e-3" + name, 40,
                [=](benchmark::State& state) { jacobi(state, count, kernel); });
        }
        for (const Index n : {33, 65, 129, 257}) {
            for (const double tolerance : {1e-3, 1e-6}) {
                add("multigrid/" + std::to_string(n) + " nodes, residual " +
                        (tolerance < 1e-5 ? "1e-6" : "1e-3") + name,
                    n > 129 ? 3 : 10,
                    [=](benchmark::State& state) { multigrid(state, n, tolerance, kernel); });
            }
        }
    }
}

}  // namespace palpate::bench
