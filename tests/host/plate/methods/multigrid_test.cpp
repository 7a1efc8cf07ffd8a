#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/plate/iterative/hierarchy.hpp"
#include "host/plate/iterative/transfer.hpp"
#include "tests/host/plate/methods/forces.hpp"

namespace palpate::plate {
namespace {

using Eigen::Index;
using namespace fields;

double random1000(double x, double z) {
    // A fixed number for every place.
    Random random(static_cast<std::uint64_t>(std::lround(1e4 * x)) * 20011 +
                  static_cast<std::uint64_t>(std::lround(1e4 * z)));
    random.next();
    return std::pow(1e3, random.next());
}

/// Iterations until the deflection under 1 N at the centre is right within `error`.
long iterations_to(const Problem& problem, double error, long most) {
    const std::vector<double> force_n = forces::at_centre(problem);
    const auto truth =
        forces::solve(Method::cholesky, problem, force_n, {.kernel = Kernel::best}).deflection_m;
    for (long k = 1; k <= most; ++k) {
        const Options options{.tolerance = 1e-30, .sweeps_max = k, .kernel = Kernel::best};
        const auto w = forces::solve(Method::multigrid, problem, force_n, options).deflection_m;
        if (forces::error(w, truth) <= error) return k;
    }
    return most + 1;
}

TEST_CASE("multigrid needs as few iterations on every grid as is known, where D is smooth") {
    // An independent code, to errors of 1e-3 / 1e-6: 3/8 to 4/9, with a smoother tuned by power iteration.
    const Index n = GENERATE(as<Index>{}, 33, 65, 129);
    CAPTURE(n);
    CHECK(iterations_to(unit_square(n, one), 1e-3, 9) <= 4);
    CHECK(iterations_to(unit_square(n, hyper10), 1e-3, 9) <= 5);
    CHECK(iterations_to(unit_square(n, wart), 1e-3, 9) <= 4);
    CHECK(iterations_to(unit_square(n, one), 1e-6, 20) <= 8);
    CHECK(iterations_to(unit_square(n, hyper10), 1e-6, 20) <= 10);
    CHECK(iterations_to(unit_square(n, wart), 1e-6, 20) <= 9);
}

TEST_CASE("multigrid takes a jump of a thousand, with more iterations") {
    // Known: 14/23 on 33 nodes, 16/30 on 65.
    CHECK(iterations_to(unit_square(33, jump1000), 1e-3, 50) <= 16);
    CHECK(iterations_to(unit_square(33, jump1000), 1e-6, 50) <= 26);
    CHECK(iterations_to(unit_square(65, jump1000), 1e-6, 50) <= 33);
}

TEST_CASE("multigrid's answer is within its tolerance on grids that coarsen a little only") {
    const Index n = GENERATE(as<Index>{}, 9, 11, 19, 25, 35, 49);
    const Problem problem = unit_square(n, hyper10);
    const std::vector<double> force_n = forces::at_centre(problem);
    const Options options{.tolerance = 1e-9};
    const forces::Answer answer = forces::solve(Method::multigrid, problem, force_n, options);
    CAPTURE(n, answer.report.iterations);
    CHECK(answer.report.status == Status::solved);
    CHECK(answer.report.residual <= 1e-9);
    CHECK(answer.report.iterations <= 20);
    CHECK(forces::error(answer.deflection_m, forces::solve(Method::eigen, problem, force_n).deflection_m) <
          1e-8);
}

TEST_CASE("grids are made coarser down to 5 to 8 nodes or an even count") {
    const auto n_grids = [](Index nx, Index nz) {
        Problem problem;
        problem.rigidity_n_m = Eigen::ArrayXXd::Ones(nx, nz);
        return Hierarchy(problem, Kernel::portable).n_grids();
    };
    CHECK(n_grids(33, 33) == 4);  // 17, 9, 5
    CHECK(n_grids(65, 17) == 3);  // 33 x 9, 17 x 5
    CHECK(n_grids(25, 25) == 3);  // 13, 7
    CHECK(n_grids(11, 33) == 2);  // 6 x 17
}

std::array<Edge, 4> some_edges(int k) {
    constexpr std::array<Edge, 3> KINDS{Edge::clamped, Edge::supported, Edge::free};
    const auto kind = [&](int by) { return KINDS.at(static_cast<std::size_t>(k / by % 3)); };
    return {kind(1), kind(3), kind(9), kind(27)};
}

std::vector<double> noise(const Layout& layout, const Moving& moving, std::uint64_t seed) {
    Random random(seed);
    std::vector<double> values(layout.size(), 0.0);
    for (Index iz = moving.z0; iz < moving.z1; ++iz) {
        for (Index ix = moving.x0; ix < moving.x1; ++ix) values[layout.at(ix, iz)] = random.next() - 0.5;
    }
    return values;
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
}

TEST_CASE("what is handed down is the transpose of what is handed up, with any edges") {
    const Layout fine{17, 13}, coarse{9, 7};
    for (int k = 0; k < 81; ++k) {
        const auto edges = some_edges(k);
        Transfer transfer(fine, coarse, edges);
        const Moving above(17, 13, edges), below(9, 7, edges);
        const std::vector<double> e = noise(coarse, below, 1), r = noise(fine, above, 2);
        std::vector<double> up(fine.size(), 0.0), down(coarse.size(), 7.0);
        transfer.prolong(e.data(), up.data());
        transfer.restrict_from(r.data(), 2.0, down.data());
        CAPTURE(k);
        CHECK(dot(down, e) == Approx(2.0 * dot(up, r)).epsilon(1e-12));
        // Nothing where nothing moves, nor around the grid.
        std::vector<double> moved(fine.size(), 0.0);
        for (Index iz = above.z0; iz < above.z1; ++iz) {
            for (Index ix = above.x0; ix < above.x1; ++ix) moved[fine.at(ix, iz)] = up[fine.at(ix, iz)];
        }
        CHECK(up == moved);
    }
}

/// Largest error of interpolating f(x) f(z) from n nodes to 2 n - 1.
template <typename Function>
double interpolation_error(Index n, Edge edge, Function&& f) {
    const Layout fine{2 * n - 1, 2 * n - 1}, coarse{n, n};
    Transfer transfer(fine, coarse, {edge, edge, edge, edge});
    std::vector<double> from(coarse.size(), 0.0), to(fine.size(), 0.0);
    const auto at = [](Index i, Index count) {
        return static_cast<double>(i) / static_cast<double>(count - 1);
    };
    for (Index iz = 0; iz < n; ++iz) {
        for (Index ix = 0; ix < n; ++ix) from[coarse.at(ix, iz)] = f(at(ix, n)) * f(at(iz, n));
    }
    transfer.prolong(from.data(), to.data());
    double error = 0.0;
    for (Index iz = 0; iz < fine.nz; ++iz) {
        for (Index ix = 0; ix < fine.nx; ++ix)
            error = std::max(error, std::fabs(to[fine.at(ix, iz)] - f(at(ix, fine.nx)) * f(at(iz, fine.nz))));
    }
    return error;
}

TEST_CASE("interpolation is cubic up to the edges") {
    constexpr double PI = std::numbers::pi;
    const auto order = [](Edge edge, auto f) {
        return std::log2(interpolation_error(17, edge, f) / interpolation_error(33, edge, f));
    };
    const auto clamped = [](double t) { return std::pow(std::sin(PI * t), 2); };
    const auto supported = [](double t) { return std::sin(PI * t); };
    const auto free = [](double t) { return 1.0 + t * (2.0 - 3.0 * t); };
    CHECK(order(Edge::clamped, clamped) == Approx(4.0).margin(0.2));
    CHECK(order(Edge::supported, supported) == Approx(4.0).margin(0.2));
    CHECK(interpolation_error(9, Edge::free, free) < 1e-14);
    // With the wrong mirror image it is not.
    CHECK(order(Edge::supported, clamped) < 3.0);
    CHECK(order(Edge::clamped, supported) < 3.0);
}

TEST_CASE("one cycle is a symmetric positive definite matrix, so that conjugate gradients may use it") {
    Problem problem = unit_square(17, random1000);
    SECTION("clamped") {}
    SECTION("any edges and a foundation") {
        problem = on_foundation(problem, 2.0);
        problem.edges = {Edge::free, Edge::supported, Edge::free, Edge::clamped};
    }
    Hierarchy hierarchy(problem, Kernel::best);
    const Layout& layout = hierarchy.finest().stencil().layout();
    const Moving& moving = hierarchy.finest().stencil().moving();
    std::vector<std::size_t> places;
    for (Index iz = moving.z0; iz < moving.z1; ++iz) {
        for (Index ix = moving.x0; ix < moving.x1; ++ix) places.push_back(layout.at(ix, iz));
    }
    const auto n = static_cast<Index>(places.size());
    Eigen::MatrixXd cycle(n, n);
    std::vector<double> f(layout.size(), 0.0), x(f);
    for (Index j = 0; j < n; ++j) {
        f[places[static_cast<std::size_t>(j)]] = 1.0;
        hierarchy.cycle(f.data(), x.data());
        f[places[static_cast<std::size_t>(j)]] = 0.0;
        for (Index i = 0; i < n; ++i) cycle(i, j) = x[places[static_cast<std::size_t>(i)]];
    }
    CHECK((cycle - cycle.transpose()).cwiseAbs().maxCoeff() < 1e-10 * cycle.cwiseAbs().maxCoeff());
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(cycle, Eigen::EigenvaluesOnly);
    CHECK(eigen.eigenvalues()(0) > 0.0);
}

TEST_CASE("D that is weighted down stays as it is where constant or linear, and positive") {
    Eigen::ArrayXXd fine = sampled(9, [](double x, double z) { return 1.0 + x + 2.0 * z; });
    Eigen::ArrayXXd coarse(5, 5), room(9, 9);
    weigh_fully(fine, coarse, room);
    CHECK((coarse.block(1, 1, 3, 3) -
           sampled(5, [](double x, double z) { return 1.0 + x + 2.0 * z; }).block(1, 1, 3, 3))
              .abs()
              .maxCoeff() < 1e-15);
    fine = sampled(9, random1000);
    weigh_fully(fine, coarse, room);
    CHECK(coarse.minCoeff() >= fine.minCoeff());
    CHECK(coarse.maxCoeff() <= fine.maxCoeff());
}

}  // namespace
}  // namespace palpate::plate
