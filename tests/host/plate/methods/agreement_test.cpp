// Every method against the dense matrix, whatever holds the plate.
#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "host/plate/plate.hpp"
#include "host/plate/stencil.hpp"
#include "tests/host/plate/methods/forces.hpp"

namespace palpate::plate {
namespace {

using Eigen::ArrayXXd;
using Eigen::Index;
using namespace fields;

constexpr std::array<Edge, 4> SUPPORTED{Edge::supported, Edge::supported, Edge::supported, Edge::supported};
constexpr std::array<Edge, 4> CANTILEVER{Edge::clamped, Edge::free, Edge::free, Edge::free};
constexpr std::array<Edge, 4> MIXED{Edge::free, Edge::supported, Edge::clamped, Edge::free};

Problem held(Problem problem, const std::array<Edge, 4>& edges) {
    problem.edges = edges;
    return problem;
}

Problem rectangle(Index n) {
    Problem problem;
    problem.size_m = {2.0, 0.9};
    problem.rigidity_n_m = sampled(2 * n - 1, linear10).leftCols(n);
    return problem;
}

Problem with_poisson_field(Index n) {
    Problem problem = held(on_foundation(unit_square(n, gauss), 3.0), MIXED);
    problem.poisson_at_nodes = sampled(n, [](double x, double z) { return 0.4 * x - 0.1 * z; });
    return problem;
}

Problem with_moved_lines(Index n) {
    Problem problem = unit_square(n, hyper10);
    const Eigen::ArrayXd t = Eigen::ArrayXd::LinSpaced(n, 0.0, 1.0);
    problem.lines_x_m = t + 0.3 * t * (1.0 - t);
    problem.lines_z_m = t - 0.2 * t * (1.0 - t);
    return problem;
}

/// 1 and 3 N m on two sides of a grid line.
Problem with_a_jump(Index n) {
    Problem problem = unit_square(n, [](double x, double) { return x < 0.5 ? 1.0 : (x > 0.5 ? 3.0 : 2.0); });
    problem.harmonic_x_n_m = problem.harmonic_z_n_m = problem.rigidity_n_m;
    problem.harmonic_x_n_m.row(n / 2).setConstant(1.5);
    return problem;
}

Problem with_a_hole(Index n) {
    Problem problem = on_foundation(unit_square(n, gauss), 2.0);
    problem.solid = sampled(n, [](double x, double z) { return std::hypot(x - 0.3, z - 0.6) - 0.15; }) > 0.0;
    return problem;
}

Problem rough(Index n) {
    Random random(5);
    return unit_square(n, [&](double, double) { return 1.0 + 3.0 * random.next(); });
}

struct Case {
    const char* name;
    std::function<Problem(Index)> problem;
};

const std::vector<Case>& cases() {
    static const std::vector<Case> all{
        {"uniform", [](Index n) { return unit_square(n, one); }},
        {"foundation", [](Index n) { return on_foundation(unit_square(n, hyper10), 8.0); }},
        {"supported", [](Index n) { return held(unit_square(n, gauss), SUPPORTED); }},
        {"cantilever", [](Index n) { return held(unit_square(n, gauss), CANTILEVER); }},
        {"Poisson field", with_poisson_field},
        {"rectangle", rectangle},
        {"moved lines", with_moved_lines},
        {"rough", rough},
        {"jump on a line", with_a_jump},
        {"hole", with_a_hole}};
    return all;
}

/// By Eigen's dense factor of Plate's matrix.
std::vector<double> truth(const Problem& problem, const std::vector<double>& force_n) {
    const Index nx = problem.rigidity_n_m.rows(), nz = problem.rigidity_n_m.cols();
    const Moving moving(nx, nz, problem.edges);
    const Index rows = moving.x1 - moving.x0, columns = moving.z1 - moving.z0;
    const Eigen::Map<const Eigen::MatrixXd> force(force_n.data(), nx, nz);
    Eigen::MatrixXd load = force.block(moving.x0, moving.z0, rows, columns).transpose();  // x slowest
    const Eigen::MatrixXd stiffness = Plate(problem).dense_stiffness_n_per_m();
    const Eigen::VectorXd w = stiffness.ldlt().solve(load.reshaped());
    Eigen::MatrixXd deflection = Eigen::MatrixXd::Zero(nx, nz);
    deflection.block(moving.x0, moving.z0, rows, columns) = w.reshaped(columns, rows).transpose();
    return {deflection.data(), deflection.data() + deflection.size()};
}

double error_of(Method method, const Problem& problem, const Options& options) {
    const std::vector<double> force_n = forces::random(problem, 3);
    const forces::Answer answer = forces::solve(method, problem, force_n, options);
    CHECK(answer.report.status == Status::solved);
    // Rounding alone leaves 2e-10 on a cantilever, whose nodes' forces are small differences.
    CHECK(answer.report.residual <= (answer.report.iterations == 0 ? 1e-9 : options.tolerance));
    return forces::error(answer.deflection_m, truth(problem, force_n));
}

TEST_CASE("every method finds what the dense matrix does, whatever the plate and its edges") {
    const Method method = GENERATE(as<Method>{}, Method::cholesky, Method::eigen, Method::multigrid);
    const Kernel kernel = GENERATE(as<Kernel>{}, Kernel::portable, Kernel::best);
    for (const Case& c : cases()) {
        CAPTURE(name_of(method), c.name);
        // The dense factor of the plate with a hole, D 1e-6 there, is itself good to some 1e-8 only.
        CHECK(error_of(method, c.problem(17), {.tolerance = 1e-10, .kernel = kernel}) < 1e-7);
    }
}

TEST_CASE("damped Jacobi arrives there too, given time") {
    for (const Case& c : cases()) {
        if (std::string(c.name) == "hole") continue;  // some 1e6 times slower
        CAPTURE(c.name);
        const Options options{.tolerance = 1e-8, .sweeps_max = 10000000};
        CHECK(error_of(Method::damped_jacobi, c.problem(9), options) < 1e-5);
    }
}

TEST_CASE("another rigidity on the same grid gives the same bits as a solver made for it") {
    const Method method = GENERATE(as<Method>{}, Method::cholesky, Method::eigen, Method::multigrid,
                                   Method::damped_jacobi, Method::eq7);
    const bool hole = GENERATE(as<bool>{}, false, true);
    if (hole && (method == Method::eq7 || method == Method::damped_jacobi)) return;
    Problem problem = hole ? with_a_hole(17) : unit_square(17, gauss);
    const std::vector<double> force_n = forces::at_centre(problem);
    const auto solver = make_solver(method, problem);
    problem.rigidity_n_m = sampled(17, hyper10);
    solver->set_rigidity(problem.rigidity_n_m);
    CHECK(forces::solve(*solver, force_n).deflection_m ==
          forces::solve(method, problem, force_n).deflection_m);
}

TEST_CASE("a solver may be asked from many threads") {
    const Method method =
        GENERATE(as<Method>{}, Method::cholesky, Method::eigen, Method::multigrid, Method::damped_jacobi);
    const Problem problem = unit_square(method == Method::damped_jacobi ? 9 : 33, gauss);
    const auto solver = make_solver(method, problem);
    const std::vector<double> force_n = forces::random(problem, 8);
    const forces::Answer alone = forces::solve(*solver, force_n);
    std::vector<int> n_wrong(4, 0);
    {
        std::vector<std::jthread> threads;
        threads.reserve(n_wrong.size());
        for (int& wrong : n_wrong) {
            threads.emplace_back([&] {
                for (int k = 0; k < 40; ++k)
                    wrong += forces::solve(*solver, force_n).deflection_m != alone.deflection_m;
            });
        }
    }
    CHECK(n_wrong == std::vector<int>(4, 0));
}

}  // namespace
}  // namespace palpate::plate
