// Brackets about the plate itself, not its grid: published and independent values lie inside.
#include "host/plate/bounds/continuum.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <string>

#include "tests/host/plate/bounds/loads.hpp"
#include "tests/host/plate/bounds/random_field.hpp"

using namespace palpate::plate;
using Eigen::ArrayXXd;
using Eigen::Index;

namespace {

constexpr Index N = 33;

/// Clamped square of side 1, centre load, D = 1.
double square_centre(double foundation_n_per_m3) {
    return uniform_square_compliance(std::sqrt(std::sqrt(foundation_n_per_m3)));
}

UniformCompliance bare(double m_per_n) {
    return [=](double) { return m_per_n; };
}

Problem rectangle(double size_z_m, Index nz, const fields::Function& rigidity) {
    Problem problem;
    problem.size_m = {1.0, size_z_m};
    problem.rigidity_n_m.resize(N, nz);
    for (Index ix = 0; ix < N; ++ix) {
        for (Index iz = 0; iz < nz; ++iz)
            problem.rigidity_n_m(ix, iz) =
                rigidity(static_cast<double>(ix) / (N - 1),
                         size_z_m * static_cast<double>(iz) / static_cast<double>(nz - 1));
    }
    return problem;
}

}  // namespace

TEST_CASE("a uniform square is bracketed within 1e-5 of Timoshenko's value") {
    const Problem problem = fields::unit_square(N, fields::one);
    const auto bracket = continuum_bracket(problem, loads::point(N, N, {16, 16}), square_centre, {}, nullptr);
    REQUIRE(bracket);
    CHECK(bracket->lower_m_per_n <= 0.005612024020);
    CHECK(bracket->upper_m_per_n >= 0.005612024020);
    CHECK(bracket->lower_m_per_n >= 0.005612024020 * (1.0 - 1e-5));
    CHECK(bracket->upper_m_per_n <= 0.005612024020 * (1.0 + 1e-5));
}

TEST_CASE("published and independent compliances of varying plates lie inside") {
    struct Anchor {
        const char* name;
        Problem problem;
        Node load;
        double uniform;  ///< same place, D = 1: boundary least squares, 1e-9
        double truth;    ///< bicubic Hermite elements graded to the load, 3e-6
    };
    const auto plate = [](double size_z_m, Index nz, double poisson, const fields::Function& rigidity) {
        Problem problem = rectangle(size_z_m, nz, rigidity);
        problem.poisson = poisson;
        return problem;
    };
    const std::array anchors{
        Anchor{"1 + x",
               plate(1.0, N, 0.3, [](double x, double) { return 1.0 + x; }),
               {16, 16},
               0.005612024020,
               0.00377153},
        Anchor{"4/(1 + 3x) at (1/4, 1/2)",
               plate(1.0, N, 0.2, [](double x, double) { return 4.0 / (1.0 + 3.0 * x); }),
               {8, 16},
               0.0032855433,
               0.00134940},
        Anchor{"1 + 4 exp", plate(1.0, N, 0.2, fields::gauss), {16, 16}, 0.005612024020, 0.00257143},
        Anchor{"exp(x + z) on 1 x 1/2",
               plate(0.5, 17, 0.2, [](double x, double z) { return std::exp(x + z); }),
               {16, 8},
               0.0072305563 / 4.0,
               0.00085000}};
    for (const Anchor& anchor : anchors) {
        const Index nz = anchor.problem.rigidity_n_m.cols();
        const loads::Force force = loads::point(N, nz, anchor.load);
        for (const Rung rung : {Rung::uniform, Rung::modes, Rung::krylov3}) {
            const auto bracket =
                continuum_bracket(anchor.problem, force, bare(anchor.uniform), {.last = rung}, nullptr);
            REQUIRE(bracket);
            INFO(anchor.name << ", " << name_of(rung) << ": " << bracket->lower_m_per_n / anchor.truth - 1.0
                             << " " << bracket->upper_m_per_n / anchor.truth - 1.0);
            CHECK(bracket->lower_m_per_n <= anchor.truth * (1.0 + 3e-6));
            CHECK(bracket->upper_m_per_n >= anchor.truth * (1.0 - 3e-6));
            if (rung == Rung::krylov3) CHECK(bracket->relative_error() < 0.02);
        }
    }
}

TEST_CASE("plates of all kinds lie inside their continuum brackets") {
    const bool soak = std::getenv("PALPATE_SOAK") != nullptr;
    const int n_wanted = soak ? 1000 : 60;
    fields::Random random(41);
    int n_checked = 0;
    for (int k = 0; n_checked < n_wanted; ++k) {
        REQUIRE(k < 3 * n_wanted);
        const auto kind = static_cast<fields::Kind>(k % (fields::N_KINDS - 1));  // noise has no continuum
        const auto rigidity =
            fields::random_field(random, kind, fields::log_uniform(random, k % 2 == 0 ? 1e2 : 1e6));
        const double side_over_l = k % 3 == 0 ? 0.0 : 4.0 + 12.0 * random.next();
        const bool one_material = random.next() < 0.5;
        const auto on_grid = [&](Index n) {
            Problem problem = fields::unit_square(n, rigidity);
            if (side_over_l > 0.0) problem = fields::on_foundation(problem, side_over_l);
            if (side_over_l > 0.0 && one_material) problem.foundation_n_per_m3 *= problem.rigidity_n_m;
            return problem;
        };
        const Problem problem = on_grid(N);
        const ContinuumBounds bounds(problem, loads::point(N, N, {16, 16}), square_centre,
                                     foundations_for(problem));
        ContinuumBounds::Scratch scratch(bounds);
        Estimate truth{};
        try {
            truth = extrapolated_centre_compliance(on_grid(129));
        } catch (const Guard&) {
            continue;
        }
        bool refused = false;
        for (const Rung rung : {Rung::uniform, Rung::modes, Rung::krylov4}) {
            std::string why;
            const auto bracket =
                bounds.bracket(loads::span_of(problem.rigidity_n_m),
                               loads::span_of(problem.foundation_n_per_m3), {.last = rung}, scratch, &why);
            refused = !bracket;
            if (refused) {
                REQUIRE_FALSE(why.empty());
                break;
            }
            INFO("plate " << k << ", a/l " << side_over_l << ", " << name_of(rung) << ": "
                          << bracket->lower_m_per_n / truth.m_per_n - 1.0 << " "
                          << bracket->upper_m_per_n / truth.m_per_n - 1.0 << ", truth known to "
                          << truth.relative_error);
            CHECK(bracket->lower_m_per_n <= truth.m_per_n * (1.0 + truth.relative_error));
            CHECK(bracket->upper_m_per_n >= truth.m_per_n / (1.0 + truth.relative_error));
        }
        n_checked += refused ? 0 : 1;
    }
}

TEST_CASE("a grid that cannot speak for the continuum is refused in words") {
    const auto why_not = [](const Problem& problem) {
        std::string why;
        const Index n = problem.rigidity_n_m.rows();
        const loads::Force force = loads::point(n, n, {n / 2, n / 2});
        CHECK_FALSE(continuum_bracket(problem, force, square_centre, {}, &why));
        return why;
    };
    CHECK_THAT(why_not(fields::unit_square(N, fields::jump1000)), Catch::Contains("factor of 100"));
    CHECK_THAT(why_not(fields::unit_square(16, fields::one)), Catch::Contains("2 m + 1"));
    CHECK_THAT(why_not(fields::on_foundation(fields::unit_square(N, fields::one), 40.0)),
               Catch::Contains("spacing"));
    Problem laminate = fields::unit_square(N, fields::hyper10);
    laminate.harmonic_x_n_m = laminate.harmonic_z_n_m = 0.9 * laminate.rigidity_n_m;
    CHECK_THAT(why_not(laminate), Catch::Contains("laminate"));
}
