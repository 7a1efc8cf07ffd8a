#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/plate/depth_law.hpp"
#include "tests/host/plate/reference/program.hpp"

namespace palpate {
namespace {

using nlohmann::json;
using reference_program::answer;
constexpr double PI = std::numbers::pi;
constexpr double RADIUS_OF_CURVATURE = 30.0;  ///< in thicknesses

/// Thickness 1, D = 1, nu = 0.2 unless changed.
json flat_disc(double radius, const std::vector<double>& depths) {
    return {{"radius_m", radius}, {"thickness_m", 1.0}, {"rigidity_n_m", 1.0}, {"depths_m", depths}};
}

/// l = (D/k_f)^(1/4) with k_f = E h/R^2.
double shell_length() {
    return std::sqrt(RADIUS_OF_CURVATURE) / std::pow(12.0 * (1.0 - 0.2 * 0.2), 0.25);
}

json cap(double radii, int sign, const std::string& edge, const std::vector<double>& depths) {
    json problem = flat_disc(radii * shell_length(), depths);
    problem["curvature_per_m"] = sign / RADIUS_OF_CURVATURE;
    problem["edge"] = edge;
    return problem;
}

double stiffness(const json& problem) {
    return answer("cap", problem)["linear_stiffness_n_per_m"];
}

TEST_CASE("a flat disc is as stiff as 16 pi D/a^2, to fourth order in the elements") {
    json problem = flat_disc(10.0, {1e-3});
    const double exact = 16.0 * PI / 100.0;
    std::vector<double> errors;
    for (const unsigned elements : {8U, 16U, 32U}) {
        problem["elements"] = elements;
        errors.push_back(stiffness(problem) / exact - 1.0);
    }
    for (std::size_t i = 1; i < errors.size(); ++i) {
        const double order = std::log2(errors[i - 1] / errors[i]);
        CHECK(order > 3.5);
        CHECK(order < 4.5);
    }
    problem["elements"] = 64U;
    CHECK(stiffness(problem) == Approx(exact).epsilon(1e-7));
}

TEST_CASE("far beyond its thickness a disc is Schwerin's membrane") {
    // nu = 1/3: w = d (1 - (r/a)^(2/3)), u = 0, so F = (pi/3) E h a (d/a)^3 in closed form. Bending adds a
    // share that falls as h/d: from 20 and 50 thicknesses to none.
    constexpr double NU = 1.0 / 3.0;
    json problem = flat_disc(10.0, {1.0, 3.0, 10.0, 20.0, 50.0});
    problem["poisson"] = NU;
    problem["rigidity_n_m"] = 1.0 / (12.0 * (1.0 - NU * NU));  // E = 1
    const json pressed = answer("cap", problem);
    const auto over_membrane = [&](std::size_t i) {
        const double depth = pressed["depths_m"][i];
        return pressed["reaction_n"][i].get<double>() / (PI / 3.0 * 10.0 * std::pow(depth / 10.0, 3.0));
    };
    CHECK((50.0 * over_membrane(4) - 20.0 * over_membrane(3)) / 30.0 == Approx(1.0).epsilon(3e-3));
}

TEST_CASE("the rims of a wide cap close in on the whole sphere's 8 sqrt(D k_f)") {
    // Reissner's point load on an unbounded shallow sphere: c = l^2/(8 D).
    const double sphere = 8.0 / shell_length() / shell_length();
    double fixed_before = 0.1;
    double free_before = 0.5;
    for (const double radii : {12.0, 24.0, 48.0}) {
        const double fixed = stiffness(cap(radii, 1, "fixed", {1e-3})) / sphere - 1.0;
        const double free = 1.0 - stiffness(cap(radii, 1, "free", {1e-3})) / sphere;
        CHECK(fixed > 0.0);
        CHECK(free > 0.0);
        CHECK(fixed < 0.4 * fixed_before);
        CHECK(free < 0.6 * free_before);
        fixed_before = fixed;
        free_before = free;
    }
    CHECK(fixed_before < 1e-3);
}

TEST_CASE("linear theory does not see which way a cap is curved") {
    CHECK(stiffness(cap(12.0, 1, "free", {1e-3})) ==
          Approx(stiffness(cap(12.0, -1, "free", {1e-3}))).epsilon(1e-9));
}

TEST_CASE("a cap pressed from outside softens, from inside it stiffens, as another program found") {
    struct Case {
        int sign;
        std::vector<double> ratio;  // of F/(k d), mean of the rims, at 0.1, 1 and 2 thicknesses
    };
    const auto wanted = GENERATE(as<Case>{}, Case{1, {0.954, 0.616, 0.418}}, Case{-1, {1.048, 1.522, 2.085}});
    const json fixed = answer("cap", cap(12.0, wanted.sign, "fixed", {0.1, 1.0, 2.0}));
    const json free = answer("cap", cap(12.0, wanted.sign, "free", {0.1, 1.0, 2.0}));
    for (std::size_t i = 0; i < 3; ++i) {
        const double mean =
            0.5 * (fixed["force_ratio"][i].get<double>() + free["force_ratio"][i].get<double>());
        CHECK(mean == Approx(wanted.ratio[i]).epsilon(2e-3));  // three digits were published
    }
}

TEST_CASE("the checked-in depth law is what caps answer today") {
    const double x = GENERATE(as<double>{}, 0.1, 1.0, 5.0);
    const auto mean = [&](int sign) {
        return 0.5 * (answer("cap", cap(12.0, sign, "fixed", {x}))["force_ratio"][0].get<double>() +
                      answer("cap", cap(12.0, sign, "free", {x}))["force_ratio"][0].get<double>());
    };
    bool found = false;
    for (const plate::DepthLawRow& row : plate::depth_law_table()) {
        if (row.x != x) continue;
        found = true;
        CHECK(row.convex == Approx(mean(1)).epsilon(1e-5));
        CHECK(row.concave == Approx(mean(-1)).epsilon(1e-5));
    }
    CHECK(found);
}

TEST_CASE("a reaction is the derivative of the energy by the depth") {
    const int sign = GENERATE(1, -1, 0);
    constexpr double STEP = 1e-3;  // central difference: error 1e-6 of a smooth law
    const json pressed = answer("cap", cap(12.0, sign, "free", {1.0 - STEP, 1.0, 1.0 + STEP}));
    const double slope =
        (pressed["energy_j"][2].get<double>() - pressed["energy_j"][0].get<double>()) / (2.0 * STEP);
    CHECK(pressed["reaction_n"][1].get<double>() == Approx(slope).epsilon(3e-6));
}

}  // namespace
}  // namespace palpate
