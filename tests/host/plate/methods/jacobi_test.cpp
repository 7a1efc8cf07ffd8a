// Jacobi's iteration: what it costs, and what its stop rule is worth. Figures of an independent code.
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>
#include <vector>

#include "host/plate/iterative/jacobi.hpp"
#include "host/plate/iterative/sweeper.hpp"
#include "tests/host/plate/methods/forces.hpp"

namespace palpate::plate {
namespace {

using Eigen::Index;
using namespace fields;

/// Sweeps from w = 0 under 1 N at the centre of the uniform unit square.
class Run {
public:
    Run(Index n, double omega)
        : sweeper_(unit_square(n, one), sweep_kernel(Kernel::best)),
          omega_(omega),
          f_(sweeper_.stencil().layout().size(), 0.0),
          x_(f_),
          next_(f_) {
        f_[sweeper_.stencil().layout().at(n / 2, n / 2)] = 1.0;
    }
    void sweep() {
        sweeper_.kernel().sweep(sweeper_.grid(), f_.data(), x_.data(), next_.data(), 1.0, omega_);
        std::swap(x_, next_);
    }
    /// Sweeps until done() or `most`.
    template <typename Done>
    long until(long most, Done&& done) {
        long sweeps = 0;
        while (sweeps < most && !done()) {
            sweep();
            ++sweeps;
        }
        return sweeps;
    }
    [[nodiscard]] const std::vector<double>& x() const { return x_; }
    [[nodiscard]] double largest() const {
        double most = 0.0;
        for (const double w : x_) most = std::max(most, std::fabs(w));
        return most;
    }
    /// The solution in the same layout.
    [[nodiscard]] std::vector<double> truth(Index n) const {
        const Problem problem = unit_square(n, one);
        const auto w = forces::solve(Method::cholesky, problem, forces::at_centre(problem)).deflection_m;
        std::vector<double> in_layout(x_.size(), 0.0);
        for (Index iz = 0; iz < n; ++iz) {
            for (Index ix = 0; ix < n; ++ix)
                in_layout[sweeper_.stencil().layout().at(ix, iz)] = w[static_cast<std::size_t>(ix + n * iz)];
        }
        return in_layout;
    }

private:
    Sweeper sweeper_;
    double omega_;
    std::vector<double> f_, x_, next_;
};

TEST_CASE("damped Jacobi needs the known number of sweeps, sixteen times more on twice the grid") {
    struct Known {
        Index n;
        double error;
        double sweeps;
    };
    const std::vector<Known> known{{17, 1e-1, 3904},  {17, 1e-2, 7808},  {17, 1e-3, 11712},
                                   {17, 1e-6, 23424}, {33, 1e-1, 60600}, {33, 1e-2, 121300}};
    for (const Known& k : known) {
        CAPTURE(k.n, k.error);
        Run run(k.n, Jacobi::DAMPED);
        const std::vector<double> truth = run.truth(k.n);
        const long sweeps = run.until(200000, [&] { return forces::error(run.x(), truth) <= k.error; });
        CHECK(static_cast<double>(sweeps) == Approx(k.sweeps).epsilon(0.01));
    }
}

TEST_CASE("Jacobi grows without bound beyond omega = 0.625, as fast as is known") {
    struct Known {
        Index n;
        double omega;
        long sweeps;
    };
    const std::vector<Known> known{{17, 1.0, 36},   {33, 1.0, 38},   {65, 1.0, 39},
                                   {17, 0.65, 712}, {33, 0.65, 450}, {17, 0.64, 3391}};
    for (const Known& k : known) {
        CAPTURE(k.n, k.omega);
        Run run(k.n, k.omega);
        CHECK(run.until(10000, [&] { return run.largest() > 1e6; }) == k.sweeps + 1);  // they count from 0
    }
    Run bounded(17, 0.625);
    CHECK(bounded.until(20000, [&] { return bounded.largest() > 1.0; }) == 20000);
}

TEST_CASE("plain Jacobi is told to have diverged, by either stop rule") {
    const Problem problem = GENERATE(unit_square(17, one), unit_square(33, hyper10));
    const StopRule stop = GENERATE(as<StopRule>{}, StopRule::residual, StopRule::change);
    const double tolerance = GENERATE(as<double>{}, 1e-3, 1e-6);
    const Report report = forces::solve(Method::jacobi, problem, forces::at_centre(problem),
                                        {.tolerance = tolerance, .stop = stop})
                              .report;
    CHECK(report.status == Status::diverged);
    CHECK(report.iterations < 100);
    CHECK(report.residual > 1.0);
}

TEST_CASE("damped Jacobi diverges too where D is rough, and says so") {
    // Largest eigenvalue of diag(K)^-1 K 3.39, more than 2/0.62.
    Random random(4);
    const Problem problem = unit_square(33, [&](double, double) { return std::pow(1e3, random.next()); });
    const Report report = forces::solve(Method::damped_jacobi, problem, forces::at_centre(problem)).report;
    CHECK(report.status == Status::diverged);
    CHECK(report.iterations < 10000);
}

TEST_CASE("the paper's stop rule leaves an error that is a thousand times its tolerance") {
    struct Known {
        double tolerance, error, margin;
        double centre;
    };
    const std::vector<Known> known{{1e-3, 0.63, 0.005, -0.52},
                                   {1e-4, 0.14, 0.005, -0.12},
                                   {1e-5, 0.017, 0.0005, -0.014},
                                   {1e-6, 0.0017, 0.00005, -0.0014}};
    const Problem problem = unit_square(17, one);
    const std::vector<double> force_n = forces::at_centre(problem);
    const auto truth = forces::solve(Method::cholesky, problem, force_n).deflection_m;
    for (const Known& k : known) {
        CAPTURE(k.tolerance);
        const forces::Answer answer = forces::solve(Method::damped_jacobi, problem, force_n,
                                                    {.tolerance = k.tolerance, .stop = StopRule::change});
        CHECK(answer.report.status == Status::solved);
        CHECK(forces::error(answer.deflection_m, truth) == Approx(k.error).margin(k.margin));
        const std::size_t centre = truth.size() / 2;
        CHECK(answer.deflection_m[centre] / truth[centre] - 1.0 == Approx(k.centre).margin(k.margin));
    }
}

TEST_CASE("the residual that Jacobi tells is the true one") {
    const Problem problem = on_foundation(unit_square(17, gauss), 8.0);
    const std::vector<double> force_n = forces::random(problem, 4);
    const Options options{.tolerance = 1e-5};
    const forces::Answer answer = forces::solve(Method::damped_jacobi, problem, force_n, options);
    REQUIRE(answer.report.status == Status::solved);
    const Stencil stencil(problem);
    std::vector<double> x(stencil.layout().size(), 0.0), force(x);
    double off = 0.0, most = 0.0;
    for (Index iz = 1; iz < 16; ++iz) {
        for (Index ix = 1; ix < 16; ++ix) {
            x[stencil.layout().at(ix, iz)] =
                answer.deflection_m[static_cast<std::size_t>(ix + 17 * iz)] / stencil.compliance_m_per_n();
        }
    }
    stencil.apply(x.data(), force.data());
    for (Index iz = 1; iz < 16; ++iz) {
        for (Index ix = 1; ix < 16; ++ix) {
            const double wanted = force_n[static_cast<std::size_t>(ix + 17 * iz)];
            off = std::max(off, std::fabs(force[stencil.layout().at(ix, iz)] - wanted));
            most = std::max(most, std::fabs(wanted));
        }
    }
    CHECK(answer.report.residual == Approx(off / most).epsilon(1e-6));
    CHECK(answer.report.residual <= options.tolerance);
    CHECK(answer.report.iterations % 32 == 0);
}

std::vector<double> noise(const Sweeper& sweeper, std::uint64_t seed) {
    Random random(seed);
    const Moving& moving = sweeper.stencil().moving();
    std::vector<double> values(sweeper.stencil().layout().size(), 0.0);
    for (Index iz = moving.z0; iz < moving.z1; ++iz) {
        for (Index ix = moving.x0; ix < moving.x1; ++ix)
            values[sweeper.stencil().layout().at(ix, iz)] = random.next() - 0.5;
    }
    return values;
}

/// All that a kernel makes of one grid.
std::vector<double> all_of(const SweepKernel& kernel, const Problem& problem) {
    const Sweeper sweeper(problem, kernel);
    const SweepGrid grid = sweeper.grid();
    const std::vector<double> f = noise(sweeper, 1), x = noise(sweeper, 2);
    std::vector<double> a = noise(sweeper, 3), b = a, c(a.size(), 0.0), d = c, e = c, g = x, h = f;
    kernel.sweep(grid, f.data(), x.data(), a.data(), 1.1, 0.62);
    kernel.sweep_on(grid, f.data(), x.data(), b.data(), 0.4, 0.62);
    kernel.residual(grid, f.data(), x.data(), c.data());
    std::vector<double> numbers{kernel.apply(grid, x.data(), d.data()),
                                kernel.dot(f.size(), f.data(), x.data())};
    kernel.start(grid, f.data(), e.data(), 0.62);
    numbers.push_back(kernel.step(f.size(), 0.3, a.data(), b.data(), g.data(), h.data()));
    const Change change = kernel.change(f.size(), f.data(), x.data());
    numbers.insert(numbers.end(), {change.difference_squared, change.next_squared});
    std::vector<double> sum = f;
    kernel.add_to(f.size(), x.data(), 0.7, sum.data());
    for (const auto* const part : {&a, &b, &c, &d, &e, &g, &h, &sum})
        numbers.insert(numbers.end(), part->begin(), part->end());
    return numbers;
}

TEST_CASE("the kernels of all instruction sets give the same bits") {
    Problem problem = GENERATE(unit_square(18, gauss), unit_square(33, hyper10));
    problem.edges = {Edge::free, Edge::supported, Edge::clamped, Edge::free};
    const std::vector<double> plain = all_of(*sweep_kernels().front(), problem);
    for (const SweepKernel* const kernel : sweep_kernels()) {
        CAPTURE(kernel->name);
        CHECK(all_of(*kernel, problem) == plain);
    }
    CHECK(std::string(sweep_kernel(Kernel::portable).name) == "baseline");
    CHECK(&sweep_kernel(Kernel::best) == sweep_kernels().back());
}

TEST_CASE("a kernel's matrix is the stencil's") {
    Problem problem = unit_square(18, gauss);
    problem.edges = {Edge::free, Edge::supported, Edge::clamped, Edge::free};
    const Sweeper sweeper(problem, sweep_kernel(Kernel::best));
    const std::vector<double> x = noise(sweeper, 2);
    std::vector<double> y(x.size(), 0.0), wanted(x.size(), 0.0);
    const double work = sweeper.kernel().apply(sweeper.grid(), x.data(), y.data());
    sweeper.stencil().apply(x.data(), wanted.data());
    CHECK(forces::error(y, wanted) < 1e-14);
    double sum = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += x[i] * wanted[i];
    CHECK(work == Approx(sum).epsilon(1e-12));
}

TEST_CASE("no eigenvalue exceeds its bound, 3.2 on the uniform plate") {
    CHECK(Sweeper(unit_square(33, one), sweep_kernel(Kernel::portable)).eigenvalue_bound() ==
          Approx(3.2).epsilon(1e-12));
    Random random(9);
    Problem problem = unit_square(33, [&](double, double) { return std::pow(1e3, random.next()); });
    problem.edges = {Edge::free, Edge::supported, Edge::clamped, Edge::free};
    const Sweeper sweeper(problem, sweep_kernel(Kernel::best));
    // Power iteration on diag(K)^-1 K: next = x + 1 * diag^-1 (0 - K x) = x - diag^-1 K x.
    const std::vector<double> zero(sweeper.stencil().layout().size(), 0.0);
    std::vector<double> x = noise(sweeper, 6), next = zero;
    double ratio = 0.0;
    for (int k = 0; k < 300; ++k) {
        sweeper.kernel().sweep(sweeper.grid(), zero.data(), x.data(), next.data(), 0.0, 1.0);
        const double size = std::sqrt(sweeper.kernel().dot(x.size(), x.data(), x.data()));
        ratio = std::sqrt(sweeper.kernel().dot(x.size(), next.data(), next.data())) / size;
        for (std::size_t i = 0; i < x.size(); ++i) x[i] = next[i] / (size * ratio);
    }
    CHECK(ratio > 2.5);
    CHECK(ratio <= sweeper.eigenvalue_bound());
    CHECK(sweeper.eigenvalue_bound() < 1.5 * ratio);
}

}  // namespace
}  // namespace palpate::plate
