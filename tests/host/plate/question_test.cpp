// Questions at the edge of what a method can answer: the answer, or the error that comes with it, holds.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "host/plate/compliance.hpp"
#include "host/plate/uniform/closed_form.hpp"
#include "tests/host/plate/fields.hpp"

namespace palpate::plate {
namespace {

using Catch::Matchers::Contains;
using Eigen::Index;
using fields::one;
using fields::unit_sheet;

Compliance asked(const Sheet& sheet, const Load& load, Index nodes, const Accuracy& accuracy = {}) {
    return compliance(sheet, {nodes, nodes}, std::array{load}, accuracy);
}

Sheet slope() {
    return unit_sheet([](double x, double) { return 1.0 + 0.5 * x; });
}

/// D = 1 on every even row of 129 x 129 values, 0.1 on the odd ones.
Sheet stripes() {
    Eigen::ArrayXXd values(129, 129);
    for (Index i = 0; i < values.rows(); ++i) values.row(i) = i % 2 == 0 ? 1.0 : 0.1;
    Sheet sheet = unit_sheet(sampled(values, {1.0, 1.0}));
    sheet.n_values = {129, 129};
    return sheet;
}

}  // namespace

TEST_CASE("a rigidity finer than the grid is neither taken for uniform nor certified, and the error holds") {
    const double truth = asked(stripes(), {.at_m = {0.5, 0.5}}, 257).m_per_n;
    CHECK(truth > 1.9 * 0.005612024);
    for (const Index nodes : {Index{17}, Index{65}}) {
        CAPTURE(nodes);
        const Compliance c = asked(stripes(), {.at_m = {0.5, 0.5}}, nodes);
        CHECK(c.method != Method::closed_form);
        CHECK(std::fabs(c.m_per_n - truth) < c.relative_error * c.m_per_n);
        CHECK_FALSE(c.bracket_m_per_n);
        CHECK_THAT(c.no_bracket_why, Contains("129 x 129"));
    }
    CHECK_THROWS_WITH(asked(stripes(), {.at_m = {0.5, 0.5}}, 65, {.method = Method::closed_form}),
                      Contains("not uniform"));
}

TEST_CASE("a plate of any length gives way as a strip does") {
    const Edge edge = GENERATE(Edge::clamped, Edge::supported);
    const std::size_t axis = GENERATE(as<std::size_t>{}, 0, 1);
    const auto strip = [&](double length, double share) {
        UniformPlate plate;
        plate.size_m = {1.0, 1.0};
        plate.size_m[static_cast<Index>(axis)] = length;
        plate.edges.fill(edge);
        Eigen::Vector2d at(0.5, 0.5);
        at[static_cast<Index>(axis)] = share * length;
        return UniformSolution(plate, {.at_m = at}).compliance().m_per_n;
    };
    const double longest_whole = strip(19.0, 0.5);
    // Timoshenko and Woinowsky-Krieger: 0.01695 supported, 0.00725 clamped, per P b^2/D.
    CHECK(longest_whole == Approx(edge == Edge::supported ? 0.01695 : 0.00725).epsilon(2e-3));
    for (const double length : {21.0, 1e3, 1e9}) {
        CAPTURE(length);
        CHECK(strip(length, 0.5) == Approx(longest_whole).epsilon(1e-10));
    }
    // At one end only the other edge is cut away.
    CHECK(strip(1e3, 0.3e-3) == Approx(strip(15.0, 0.02)).epsilon(1e-9));
}

TEST_CASE("a load close to an edge is answered or refused in words, never below zero") {
    for (const double x : {0.05, 0.025, 0.0125}) {
        CAPTURE(x);
        const Compliance c = asked(slope(), {.at_m = {x, 0.5}}, 65);
        REQUIRE(c.bracket_m_per_n);
        CHECK(c.m_per_n > (*c.bracket_m_per_n)[0]);
        CHECK(c.m_per_n < (*c.bracket_m_per_n)[1]);
    }
    CHECK_THROWS_WITH(asked(slope(), {.at_m = {1e-5, 0.5}}, 65), Contains("1e-05 m from an edge"));
    CHECK_THROWS_WITH(asked(unit_sheet(one), {.at_m = {1e-6, 0.5}}, 65), Contains("from an edge"));
    int n_refused = 0;
    for (double d = 1e-3; d > 1e-14; d /= 10.0) {
        CAPTURE(d);
        try {
            const Compliance c =
                asked(unit_sheet(one), {.at_m = {d, d}}, 65, {.method = Method::closed_form});
            CHECK(c.m_per_n > 0.0);
            CHECK((!c.bracket_m_per_n || (*c.bracket_m_per_n)[0] > 0.0));
        } catch (const std::invalid_argument&) {
            ++n_refused;
        }
    }
    CHECK(n_refused > 0);
}

TEST_CASE("automatic never ends where another method answers") {
    const Accuracy sharp{.tolerance = 1e-7, .bracket = false};
    CHECK(asked(slope(), {.at_m = {0.5, 0.5}}, 257, sharp).status == Status::solved);
    Sheet sheet = unit_sheet(one);
    sheet.foundation_n_per_m3 = [](double, double) { return 1e6; };  // l = 0.032
    const Load wide{.at_m = {0.5, 0.5}, .radius_m = 0.25};
    const Compliance c = asked(sheet, wide, 65);
    const double cholesky = asked(sheet, wide, 65, {.method = Method::cholesky}).m_per_n;
    CHECK(c.m_per_n == Approx(cholesky).epsilon(c.relative_error));
}

TEST_CASE("a disc on a plate of varying rigidity has certified bounds, with its compliance between them") {
    const double radius = GENERATE(0.01, 0.05, 0.2);
    const Load disc{.at_m = {0.4, 0.55}, .radius_m = radius};
    const Compliance c = asked(slope(), disc, 65, {.method = Method::cholesky});
    REQUIRE(c.bracket_m_per_n);
    const double fine = asked(slope(), disc, 129, {.method = Method::cholesky}).m_per_n;
    CHECK(fine > (*c.bracket_m_per_n)[0]);
    CHECK(fine < (*c.bracket_m_per_n)[1]);
    CHECK((*c.bracket_m_per_n)[1] / (*c.bracket_m_per_n)[0] < 1.01);
}

}  // namespace palpate::plate
