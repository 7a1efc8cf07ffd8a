#include "host/plate/field.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "host/plate/plate.hpp"
#include "tests/host/plate/fields.hpp"

namespace palpate::plate {
namespace {

using Catch::Matchers::Contains;
using Eigen::Index;
using fields::one;
using fields::unit_sheet;

TEST_CASE("a sampled field is itself at its own places, and linear or nearest between them") {
    Eigen::ArrayXXd values(3, 2);
    values << 1.0, 2.0, 3.0, 5.0, 7.0, 11.0;
    const Field linear = sampled(values, {0.2, 0.1});
    const Field nearest = sampled(values, {0.2, 0.1}, Sampling::nearest);
    for (Index i = 0; i < 3; ++i) {
        for (Index j = 0; j < 2; ++j) {
            const double x = 0.1 * static_cast<double>(i), z = 0.1 * static_cast<double>(j);
            CHECK(linear(x, z) == Approx(values(i, j)).epsilon(1e-14));
            CHECK(nearest(x, z) == values(i, j));
        }
    }
    CHECK(linear(0.05, 0.05) == Approx((1.0 + 3.0 + 2.0 + 5.0) / 4.0));
    CHECK(nearest(0.049, 0.0) == 1.0);
    CHECK(nearest(0.051, 0.0) == 3.0);
    CHECK(nearest(0.2, 0.1) == 11.0);
    CHECK(sampled(Eigen::ArrayXXd::Constant(1, 1, 4.0), {0.2, 0.1})(0.13, 0.02) == 4.0);
    CHECK_THROWS_AS(sampled({}, {0.2, 0.1}), std::invalid_argument);
}

TEST_CASE("grid lines move so that any place is a node of a grid and of its coarser ones") {
    const double x = GENERATE(as<double>{}, 0.07, 0.3, 0.5, 0.61803, 0.9);
    const Eigen::Vector2d place(x, 0.37);
    const Sheet sheet = unit_sheet(one);
    const Problem fine = on_grid(sheet, 33, 65, NodeAt{place, 2});
    REQUIRE_FALSE(problem_with(fine).has_value());
    const Node node = nearest_node(fine, place);
    CHECK(fine.lines_x_m(node.ix) == Approx(x).epsilon(1e-15));
    CHECK(fine.lines_z_m(node.iz) == Approx(0.37).epsilon(1e-15));
    CHECK(node.ix % 4 == 0);
    const Problem coarse = on_grid(sheet, 9, 17, NodeAt{place, 0});
    for (Index i = 0; i < 9; ++i) CHECK(coarse.lines_x_m(i) == Approx(fine.lines_x_m(4 * i)).margin(1e-15));
}

TEST_CASE("moved grid lines cost no order: a made-up deflection comes back with second order") {
    // w = (x(1-x)z(1-z))^2, D = 1: q = f'''' g + 2 f'' g'' + f g'''', f = (x - x^2)^2.
    const auto f = [](double t) { return t * t * (1.0 - t) * (1.0 - t); };
    const auto f2 = [](double t) { return 2.0 - 12.0 * t + 12.0 * t * t; };
    const auto largest_error = [&](Index n) {
        const Problem problem = on_grid(unit_sheet(one), n, n, NodeAt{{0.37, 0.55}, 0});
        const Eigen::ArrayXd &x = problem.lines_x_m, &z = problem.lines_z_m;
        std::vector<double> force(static_cast<std::size_t>(n * n), 0.0), w(force.size());
        for (Index i = 1; i + 1 < n; ++i) {
            for (Index j = 1; j + 1 < n; ++j) {
                const double area = 0.25 * (x(i + 1) - x(i - 1)) * (z(j + 1) - z(j - 1));
                force[static_cast<std::size_t>(i + n * j)] =
                    area * (24.0 * f(z(j)) + 2.0 * f2(x(i)) * f2(z(j)) + 24.0 * f(x(i)));
            }
        }
        Plate(problem).solve(force, w);
        double worst = 0.0;
        for (Index i = 0; i < n; ++i) {
            for (Index j = 0; j < n; ++j)
                worst =
                    std::max(worst, std::fabs(w[static_cast<std::size_t>(i + n * j)] - f(x(i)) * f(z(j))));
        }
        return worst * 256.0;
    };
    const double coarse = largest_error(33), fine = largest_error(65);
    CHECK(coarse < 1e-2);
    CHECK(std::log2(coarse / fine) == Approx(2.0).margin(0.1));
}

TEST_CASE(
    "a Poisson's ratio that changes from place to place bends as the equation says, with second order") {
    // D = 1, nu = nu(x): q = lap^2 w + nu''(x) w_zz, from (1). w as above, nu = 0.45 sin^2(3 x).
    const auto f = [](double t) { return t * t * (1.0 - t) * (1.0 - t); };
    const auto f2 = [](double t) { return 2.0 - 12.0 * t + 12.0 * t * t; };
    const auto nu2 = [](double x) { return 0.45 * 18.0 * std::cos(6.0 * x); };
    const auto largest_error = [&](Index n) {
        Sheet sheet = unit_sheet(one);
        sheet.poisson_at = [](double x, double) { return 0.45 * std::sin(3.0 * x) * std::sin(3.0 * x); };
        const Problem problem = on_grid(sheet, n, n);
        const double h = 1.0 / static_cast<double>(n - 1);
        std::vector<double> force(static_cast<std::size_t>(n * n), 0.0), w(force.size());
        for (Index i = 1; i + 1 < n; ++i) {
            for (Index j = 1; j + 1 < n; ++j) {
                const double x = h * static_cast<double>(i), z = h * static_cast<double>(j);
                const double q = 24.0 * f(z) + 2.0 * f2(x) * f2(z) + 24.0 * f(x) + nu2(x) * f(x) * f2(z);
                force[static_cast<std::size_t>(i + n * j)] = h * h * q;
            }
        }
        Plate(problem).solve(force, w);
        double worst = 0.0;
        for (Index i = 0; i < n; ++i) {
            for (Index j = 0; j < n; ++j) {
                const double x = h * static_cast<double>(i), z = h * static_cast<double>(j);
                worst = std::max(worst, std::fabs(w[static_cast<std::size_t>(i + n * j)] - f(x) * f(z)));
            }
        }
        return worst * 256.0;
    };
    const double coarse = largest_error(33), fine = largest_error(65);
    CHECK(coarse < 1e-2);
    CHECK(std::log2(coarse / fine) == Approx(2.0).margin(0.1));
}

/// Computed apart from this code: D = 1 | 5 at x = 1/2, nu = 0.3, load at (1/4, 1/2).
constexpr double JUMP_ANCHOR = 0.0027122;

Problem jump_problem(Index n) {
    return on_grid(unit_sheet([](double x, double) { return x < 0.5 ? 1.0 : 5.0; }, 0.3), n, n);
}

TEST_CASE("the laminate rule keeps the accuracy at a jump of the rigidity along a grid line") {
    const Problem problem = jump_problem(33);
    REQUIRE(problem.harmonic_x_n_m.size() != 0);
    CHECK(problem.rigidity_n_m(16, 7) == 3.0);
    CHECK(problem.harmonic_x_n_m(16, 7) == Approx(2.0 / (1.0 + 0.2)));
    CHECK(problem.harmonic_z_n_m(16, 7) == 3.0);
    CHECK(problem.harmonic_x_n_m(15, 7) == 1.0);
    const auto error = [](Problem p, bool laminate) {
        if (!laminate) p.harmonic_x_n_m = p.harmonic_z_n_m = Eigen::ArrayXXd();
        const Index quarter = (p.rigidity_n_m.rows() - 1) / 4;
        return extrapolated_compliance(p, {quarter, 2 * quarter}).m_per_n / JUMP_ANCHOR - 1.0;
    };
    CHECK(std::fabs(error(jump_problem(65), true)) < 3e-4);   // the anchor itself is sure to 1e-5
    CHECK(std::fabs(error(jump_problem(65), false)) > 3e-4);  // the mean alone
    Problem turned = jump_problem(65);
    turned.rigidity_n_m = turned.rigidity_n_m.transpose().eval();
    std::swap(turned.harmonic_x_n_m, turned.harmonic_z_n_m);
    turned.harmonic_x_n_m = turned.harmonic_x_n_m.transpose().eval();
    turned.harmonic_z_n_m = turned.harmonic_z_n_m.transpose().eval();
    CHECK(extrapolated_compliance(turned, {32, 16}).m_per_n ==
          Approx(extrapolated_compliance(jump_problem(65), {16, 32}).m_per_n).epsilon(1e-10));
}

TEST_CASE("a smooth field, or a jump between grid lines, has no laminate") {
    CHECK(on_grid(unit_sheet([](double x, double z) { return 1.0 + 9.0 * x * z; }), 33, 33)
              .harmonic_x_n_m.size() == 0);
    CHECK(on_grid(unit_sheet([](double x, double) { return x > 0.4 ? 1e3 : 1.0; }), 33, 33)
              .harmonic_x_n_m.size() == 0);
}

TEST_CASE("supported and free edges bend as in the tables") {
    SECTION("supported all round, load at the centre: 0.01160 P a^2/D") {
        Sheet sheet = unit_sheet(one);
        sheet.edges.fill(Edge::supported);
        const Estimate c = extrapolated_centre_compliance(on_grid(sheet, 65, 65));
        CHECK(c.m_per_n == Approx(0.0116008).epsilon(2e-5));
    }
    SECTION("two edges supported, two free, load per area, nu = 0.3: 0.01309 and 0.01501 q a^4/D") {
        Sheet sheet = unit_sheet(one, 0.3);
        sheet.edges = {Edge::supported, Edge::supported, Edge::free, Edge::free};
        const auto deflection = [&](Index n, Index row) {
            const double h = 1.0 / static_cast<double>(n - 1);
            std::vector<double> force(static_cast<std::size_t>(n * n)), w(force.size());
            for (Index k = 0; k < n * n; ++k)
                force[static_cast<std::size_t>(k)] = h * h * (k < n || k >= n * (n - 1) ? 0.5 : 1.0);
            Plate(on_grid(sheet, n, n)).solve(force, w);
            return w[static_cast<std::size_t>(n / 2 + n * row)];
        };
        CHECK((4.0 * deflection(65, 32) - deflection(33, 16)) / 3.0 == Approx(0.01309).margin(5e-6));
        CHECK((4.0 * deflection(65, 0) - deflection(33, 0)) / 3.0 == Approx(0.01501).margin(5e-6));
    }
    SECTION("a cantilever with free sides, nu = 0, load along its tip: L^3/(3 D b)") {
        Sheet sheet = unit_sheet(one, 0.0);
        sheet.size_m = {1.0, 0.25};
        sheet.edges = {Edge::clamped, Edge::free, Edge::free, Edge::free};
        const Index nx = 33, nz = 9;
        std::vector<double> force(static_cast<std::size_t>(nx * nz), 0.0), w(force.size());
        for (Index j = 0; j < nz; ++j)
            force[static_cast<std::size_t>(nx - 1 + nx * j)] = j == 0 || j == nz - 1 ? 1.0 / 16.0 : 1.0 / 8.0;
        Plate(on_grid(sheet, nx, nz)).solve(force, w);
        for (Index j = 0; j < nz; ++j)  // h^2/2 of second-order error
            CHECK(w[static_cast<std::size_t>(nx - 1 + nx * j)] * 3.0 * 0.25 ==
                  Approx(1.0 + 0.5 / 1024.0).epsilon(1e-6));
    }
}

TEST_CASE("a strip cut out by a mask bends like a cantilever to 0.05 % on 65 nodes") {
    constexpr Index N = 65, ROWS = 9, TIP = 48;
    constexpr double H = 1.0 / 64.0;
    Sheet sheet = unit_sheet(one, 0.0);
    sheet.solid = [](double x, double z) {
        return x < (static_cast<double>(TIP) + 0.5) * H &&
                       std::fabs(z - 0.5) < 0.5 * static_cast<double>(ROWS) * H
                   ? 1.0
                   : -1.0;
    };
    const Plate plate(on_grid(sheet, N, N));
    std::vector<double> force(static_cast<std::size_t>(N * N), 0.0), w(force.size());
    const auto tip = [](Index row) { return static_cast<std::size_t>(TIP + N * (N / 2 + row)); };
    for (Index row = -ROWS / 2; row <= ROWS / 2; ++row) force[tip(row)] = 1.0 / static_cast<double>(ROWS);
    plate.solve(force, w);
    const double length = static_cast<double>(TIP) * H, width = static_cast<double>(ROWS) * H;
    CHECK(w[tip(0)] * 3.0 * width / (length * length * length) == Approx(1.0).margin(5e-4));
}

TEST_CASE("plates that cannot be solved are refused in words") {
    Problem problem = on_grid(unit_sheet(one), 9, 9);
    SECTION("free all round") {
        problem.edges.fill(Edge::free);
        CHECK_THAT(problem_with(problem).value_or(""), Contains("tilting"));
        problem.foundation_n_per_m3 = Eigen::ArrayXXd::Constant(9, 9, 1.0);
        CHECK_FALSE(problem_with(problem).has_value());
    }
    SECTION("hinged on one edge") {
        problem.edges = {Edge::supported, Edge::free, Edge::free, Edge::free};
        CHECK_THAT(problem_with(problem).value_or(""), Contains("tilting"));
    }
    SECTION("mask of another size, or without any plate") {
        problem.solid = Mask::Constant(9, 8, true);
        CHECK_THAT(problem_with(problem).value_or(""), Contains("mask of 9 x 8"));
        problem.solid = Mask::Constant(9, 9, false);
        CHECK_THAT(problem_with(problem).value_or(""), Contains("no node has any plate"));
    }
    SECTION("grid lines that do not span the plate, or do not ascend, or crowd") {
        problem.lines_x_m = Eigen::ArrayXd::LinSpaced(9, 0.0, 0.9);
        CHECK_THAT(problem_with(problem).value_or(""), Contains("grid lines along x must run from 0"));
        problem.lines_x_m = Eigen::ArrayXd::LinSpaced(9, 0.0, 1.0);
        problem.lines_x_m(4) = problem.lines_x_m(5);
        CHECK_THAT(problem_with(problem).value_or(""), Contains("must ascend"));
        problem.lines_x_m(4) = 0.51;
        problem.lines_x_m(5) = 0.52;
        CHECK_THAT(problem_with(problem).value_or(""), Contains("factor of 4"));
    }
    SECTION("a Poisson's ratio at a node") {
        problem.poisson_at_nodes = Eigen::ArrayXXd::Constant(9, 9, 0.3);
        problem.poisson_at_nodes(2, 7) = 0.5;
        CHECK_THAT(problem_with(problem).value_or(""), Contains("Poisson's ratio 0.5 at node (2, 7)"));
    }
    SECTION("one harmonic mean alone") {
        problem.harmonic_x_n_m = problem.rigidity_n_m;
        CHECK_THAT(problem_with(problem).value_or(""), Contains("both or neither"));
    }
    SECTION("rigidity in a hole does not matter") {
        problem.solid = Mask::Constant(9, 9, true);
        problem.solid(3, 3) = false;
        problem.rigidity_n_m(3, 3) = 0.0;
        CHECK_FALSE(problem_with(problem).has_value());
    }
}

}  // namespace
}  // namespace palpate::plate
