// The paper's equation 7 by central differences: right where D is smooth, wrong by any factor where it is
// not. Figures found by an independent code.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "tests/host/plate/methods/forces.hpp"

namespace palpate::plate {
namespace {

using Catch::Matchers::Contains;
using Eigen::Index;
using namespace fields;

constexpr const char* NEGATIVE = "eq7 gives a negative compliance: ";
constexpr const char* UNTRUSTED = "eq7 cannot be trusted: ";

/// Deflection under 1 N at the centre, from the words in which eq. 7 refuses to give it.
double refused_compliance(const Problem& problem) {
    const std::vector<double> force_n = forces::at_centre(problem);
    std::string words;
    try {
        (void)forces::solve(Method::eq7, problem, force_n);
    } catch (const Guard& guard) {
        words = guard.what();
    }
    REQUIRE_THAT(words, Catch::Matchers::StartsWith(NEGATIVE) || Catch::Matchers::StartsWith(UNTRUSTED));
    const std::string known = "the work of the forces is ";
    return std::stod(words.substr(words.find(known) + known.size()));
}

Problem centre_node(Index n, double rigidity_n_m) {
    Problem problem = unit_square(n, one);
    problem.rigidity_n_m(n / 2, n / 2) = rigidity_n_m;
    return problem;
}

Problem jump(Index n, double before_n_m, double behind_n_m) {
    return unit_square(n, [=](double x, double) { return x > 0.4 ? behind_n_m : before_n_m; });
}

Problem disc(Index n, double rigidity_n_m) {
    return unit_square(
        n, [=](double x, double z) { return std::hypot(x - 0.5, z - 0.5) <= 0.15 ? rigidity_n_m : 1.0; });
}

TEST_CASE(
    "eq. 7 has compliances that are known to be wrong, by any factor and of either sign, and refuses them") {
    struct Known {
        const char* name;
        Problem problem;
        double compliance;
    };
    const std::vector<Known> known{
        {"node 0.5", centre_node(17, 0.5), 2.55e-1},  {"node 0.5", centre_node(33, 0.5), -7.66e-2},
        {"node 0.2", centre_node(17, 0.2), -5.70e-3}, {"node 0.2", centre_node(33, 0.2), -4.12e-3},
        {"node 5", centre_node(17, 5.0), -1.16e-3},   {"node 5", centre_node(33, 5.0), -8.5e-4},
        {"node 2", centre_node(33, 2.0), 7.27e-3},    {"jump 1:3", jump(17, 1.0, 3.0), -2.47e-4},
        {"jump 1:3", jump(33, 1.0, 3.0), 6.96e-4},    {"jump 1:1e3", jump(33, 1.0, 1e3), 3.75e-6},
        {"jump 1e3:1", jump(33, 1e3, 1.0), 4.38e-3},  {"disc 2", disc(33, 2.0), -4.03e-3},
        {"disc 0.2", disc(17, 0.2), -1.22e-2}};
    for (const Known& k : known) {
        CAPTURE(k.name, k.problem.rigidity_n_m.rows());
        CHECK(refused_compliance(k.problem) == Approx(k.compliance).epsilon(6e-3));
    }
}

TEST_CASE("a negative compliance of eq. 7 is refused, where the energy form has a good one") {
    const Problem problem = centre_node(33, 0.5);
    const std::vector<double> force_n = forces::at_centre(problem);
    CHECK_THROWS_AS(forces::solve(Method::eq7, problem, force_n), Guard);
    CHECK_THROWS_WITH(forces::solve(Method::eq7, problem, force_n), Contains(NEGATIVE));
    CHECK(forces::solve(Method::cholesky, problem, force_n).deflection_m[force_n.size() / 2] ==
          Approx(5.867652696e-3).epsilon(1e-9));
}

TEST_CASE("eq. 7 is the energy form where D is constant or linear") {
    Problem problem = GENERATE(unit_square(17, one), unit_square(17, linear10),
                               unit_square(17, [](double x, double z) { return 1.0 + x + 2.0 * z; }),
                               on_foundation(unit_square(17, linear10), 6.0));
    problem.size_m = {1.3, 0.7};
    problem.poisson = 0.3;
    const std::vector<double> force_n = forces::random(problem, 2);
    CHECK(forces::error(forces::solve(Method::eq7, problem, force_n).deflection_m,
                        forces::solve(Method::cholesky, problem, force_n).deflection_m) < 1e-11);
}

/// Coefficients by ascending power.
using Polynomial = std::vector<double>;

double value(const Polynomial& p, double t) {
    double sum = 0.0;
    for (std::size_t k = p.size(); k-- > 0;) sum = sum * t + p[k];
    return sum;
}

Polynomial derivative(const Polynomial& p, int times) {
    Polynomial q = p;
    for (; times > 0; --times) {
        for (std::size_t k = 1; k < q.size(); ++k) q[k - 1] = static_cast<double>(k) * q[k];
        q.pop_back();
    }
    return q;
}

/// Largest error over the largest deflection of w = (x(1-x) z(1-z))^2 (1+x) under the load that belongs to
/// it, D = 10/(1+9x).
double made_up_error(Method method, Index n) {
    const Polynomial f{0, 0, 1, -1, -1, 1}, g{0, 0, 1, -2, 1};
    const auto w = [&](double x, double z, int in_x, int in_z) {
        return value(derivative(f, in_x), x) * value(derivative(g, in_z), z);
    };
    const auto load = [&](double x, double z) {
        const double t = 1.0 + 9.0 * x;
        const double d = 10.0 / t, d_x = -90.0 / (t * t), d_xx = 1620.0 / (t * t * t);
        const double lap2 = w(x, z, 4, 0) + 2.0 * w(x, z, 2, 2) + w(x, z, 0, 4);
        const double lap_x = w(x, z, 3, 0) + w(x, z, 1, 2), lap = w(x, z, 2, 0) + w(x, z, 0, 2);
        return d * lap2 + 2.0 * d_x * lap_x + d_xx * lap - 0.8 * d_xx * w(x, z, 0, 2);
    };
    const Problem problem = unit_square(n, hyper10);
    const Eigen::ArrayXXd exact = sampled(n, [&](double x, double z) { return w(x, z, 0, 0); });
    const Eigen::ArrayXXd force = sampled(n, load) / static_cast<double>((n - 1) * (n - 1));
    const auto found =
        forces::solve(method, problem, {force.data(), force.data() + force.size()}).deflection_m;
    return (Eigen::Map<const Eigen::ArrayXXd>(found.data(), n, n) - exact).abs().maxCoeff() /
           exact.maxCoeff();
}

TEST_CASE("eq. 7 is of second order where D is smooth, though worse than the energy form") {
    // Errors as an independent code has them, of both.
    CHECK(made_up_error(Method::eq7, 17) == Approx(2.70e-2).epsilon(5e-3));
    CHECK(made_up_error(Method::eq7, 33) == Approx(6.8e-3).epsilon(1e-2));
    CHECK(made_up_error(Method::eq7, 65) == Approx(1.71e-3).epsilon(5e-3));
    CHECK(made_up_error(Method::cholesky, 17) == Approx(2.40e-2).epsilon(5e-3));
    CHECK(made_up_error(Method::cholesky, 65) == Approx(1.52e-3).epsilon(5e-3));
    CHECK(std::log2(made_up_error(Method::eq7, 33) / made_up_error(Method::eq7, 65)) ==
          Approx(2.0).margin(0.03));
}

TEST_CASE("eq. 7 refuses what it has no terms for") {
    const Problem problem = unit_square(9, one);
    const auto refused = [](const Problem& p, const char* words) {
        CHECK_THROWS_AS(make_solver(Method::eq7, p), std::invalid_argument);
        CHECK_THROWS_WITH(make_solver(Method::eq7, p), Contains("eq7: ") && Contains(words));
    };
    Problem bad = problem;
    bad.edges[2] = GENERATE(as<Edge>{}, Edge::supported, Edge::free);
    refused(bad, "clamped");
    bad = problem;
    bad.poisson_at_nodes = Eigen::ArrayXXd::Constant(9, 9, 0.1);
    refused(bad, "Poisson");
    bad = problem;
    bad.lines_z_m =
        Eigen::ArrayXd::LinSpaced(9, 0.0, 1.0).square() * 0.2 + Eigen::ArrayXd::LinSpaced(9, 0.0, 1.0) * 0.8;
    refused(bad, "evenly spaced");
    bad = problem;
    bad.solid = Mask::Constant(9, 9, true);
    refused(bad, "plate everywhere");
    bad = problem;
    bad.harmonic_x_n_m = bad.harmonic_z_n_m = bad.rigidity_n_m;
    refused(bad, "jumps");
}

}  // namespace
}  // namespace palpate::plate
