// What is refused, and in which words; how an iteration may end.
#include <catch2/catch.hpp>
#include <limits>
#include <string>
#include <vector>

#include "tests/host/plate/methods/forces.hpp"

namespace palpate::plate {
namespace {

using Catch::Matchers::Contains;
using namespace fields;

constexpr double NOT_A_NUMBER = std::numeric_limits<double>::quiet_NaN();
constexpr double INFINITE = std::numeric_limits<double>::infinity();

Method any_method() {
    return GENERATE(as<Method>{}, Method::cholesky, Method::multigrid, Method::eigen, Method::jacobi,
                    Method::damped_jacobi, Method::eq7);
}

TEST_CASE("methods have names and are found by them") {
    const Method method =
        GENERATE(as<Method>{}, Method::automatic, Method::cholesky, Method::multigrid, Method::closed_form,
                 Method::bounds, Method::eigen, Method::jacobi, Method::damped_jacobi, Method::eq7);
    CHECK(method_named(name_of(method)) == method);
    CHECK(std::string(name_of(Method::damped_jacobi)) == "damped-jacobi");
    CHECK(std::string(name_of(Status::not_converged)) == "not-converged");
    CHECK_FALSE(method_named("Cholesky").has_value());
    CHECK_FALSE(method_named("").has_value());
}

TEST_CASE("no solver for any forces is made of a method that is none") {
    const Method method = GENERATE(as<Method>{}, Method::automatic, Method::closed_form, Method::bounds);
    CHECK_THROWS_AS(make_solver(method, unit_square(9, one)), std::invalid_argument);
}

TEST_CASE("a wrong problem is refused by every method, in the words of problem_with") {
    const Method method = any_method();
    Problem problem = unit_square(9, one);
    problem.rigidity_n_m(3, 4) = -1.0;
    CHECK_THROWS_WITH(make_solver(method, problem), Contains("rigidity -1 at node (3, 4)"));
}

TEST_CASE("a rigidity that comes later is checked as well, and the old one stays") {
    const Method method = any_method();
    if (method == Method::jacobi) return;  // never solves
    const Problem problem = unit_square(9, [](double x, double z) { return 1.0 + x + z; });
    const auto solver = make_solver(method, problem);
    const std::vector<double> force_n = forces::at_centre(problem);
    const forces::Answer before = forces::solve(*solver, force_n);
    Eigen::ArrayXXd bad = problem.rigidity_n_m;
    bad(2, 3) = GENERATE(as<double>{}, 0.0, -1.0, NOT_A_NUMBER, INFINITE, 1e-20);
    CHECK_THROWS_AS(solver->set_rigidity(bad), Guard);
    CHECK_THROWS_AS(solver->set_rigidity(Eigen::ArrayXXd::Ones(9, 8)), std::invalid_argument);
    CHECK(forces::solve(*solver, force_n).deflection_m == before.deflection_m);
}

TEST_CASE("forces that are not numbers, or too few, are refused by every method") {
    const Method method = any_method();
    const Problem problem = unit_square(9, one);
    const auto solver = make_solver(method, problem);
    std::vector<double> force_n = forces::at_centre(problem), deflection_m(force_n.size());
    force_n[40] = GENERATE(as<double>{}, NOT_A_NUMBER, INFINITE, -INFINITE);
    CHECK_THROWS_WITH(solver->solve(force_n, deflection_m), Contains("not finite"));
    force_n.pop_back();
    CHECK_THROWS_AS(solver->solve(force_n, deflection_m), std::invalid_argument);
    CHECK_THROWS_AS(solver->solve(forces::at_centre(problem), {}), std::invalid_argument);
}

TEST_CASE("no forces, or forces only where nothing moves, bend nothing") {
    const Method method = any_method();
    const Problem problem = unit_square(9, one);
    std::vector<double> force_n(81, 0.0);
    force_n[0] = GENERATE(as<double>{}, 0.0, 5.0);
    const forces::Answer answer = forces::solve(method, problem, force_n);
    CHECK(answer.report.status == Status::solved);
    CHECK(answer.report.residual == 0.0);
    CHECK(answer.deflection_m == std::vector<double>(81, 0.0));
}

TEST_CASE("an iteration that runs out of sweeps has not converged") {
    const Method method = GENERATE(as<Method>{}, Method::multigrid, Method::damped_jacobi);
    const Problem problem = unit_square(17, hyper10);
    const Report report =
        forces::solve(method, problem, forces::at_centre(problem), {.sweeps_max = 2}).report;
    CHECK(report.status == Status::not_converged);
    CHECK(report.iterations == 2);
    CHECK(report.residual > 1e-6);
}

TEST_CASE("multigrid gives up when the residual has long ceased to fall") {
    // A jump of a million does not coarsen.
    const Problem problem = unit_square(129, [](double x, double) { return x > 0.4 ? 1e6 : 1.0; });
    const Report report = forces::solve(Method::multigrid, problem, forces::at_centre(problem)).report;
    CHECK(report.status == Status::not_converged);
    CHECK(report.iterations < 200);
    CHECK(report.residual > 1e-6);
}

TEST_CASE("multigrid does not tell a residual that rounding forbids") {
    const Problem problem = unit_square(33, hyper10);
    const Report report =
        forces::solve(Method::multigrid, problem, forces::at_centre(problem), {.tolerance = 1e-30}).report;
    CHECK(report.status == Status::not_converged);
    CHECK(report.iterations < 100);
    CHECK(report.residual < 1e-9);
}

TEST_CASE("multigrid that meets numbers beyond double's range has diverged, and is well the next time") {
    const Problem problem = unit_square(17, one);
    const auto solver = make_solver(Method::multigrid, problem);
    const std::vector<double> force_n = forces::at_centre(problem);
    const forces::Answer before = forces::solve(*solver, force_n);
    std::vector<double> huge_n = force_n;
    for (double& force : huge_n) force *= 1e300;
    const Report report = forces::solve(*solver, huge_n).report;
    CHECK(report.status == Status::diverged);
    CHECK(report.iterations == 0);  // at once, not when patience ends
    CHECK(forces::solve(*solver, force_n).deflection_m == before.deflection_m);
}

TEST_CASE("multigrid refuses what it cannot make coarser, or stop by") {
    CHECK_THROWS_WITH(make_solver(Method::multigrid, unit_square(16, one)),
                      Contains("16 x 16") && Contains("odd"));
    CHECK_THROWS_WITH(make_solver(Method::multigrid, unit_square(7, one)), Contains("at least 9"));
    CHECK_THROWS_WITH(make_solver(Method::multigrid, unit_square(17, one), {.stop = StopRule::change}),
                      Contains("residual only"));
    CHECK_NOTHROW(make_solver(Method::multigrid, unit_square(11, one)));  // 11 -> 6
}

}  // namespace
}  // namespace palpate::plate
