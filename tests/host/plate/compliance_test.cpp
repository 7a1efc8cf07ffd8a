#include "host/plate/compliance.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "host/plate/variation.hpp"
#include "tests/host/plate/fields.hpp"

namespace palpate::plate {
namespace {

using Catch::Matchers::Contains;
using Eigen::Index;
using fields::one;
using fields::unit_sheet;

Compliance solved(const Sheet& sheet, const Load& load, Index nodes, Method method = Method::cholesky,
                  const Wanted& wanted = {}) {
    return compliance(sheet, {nodes, nodes}, std::array{load}, {.method = method}, wanted);
}

struct Anchor {
    const char* name;
    Field rigidity;
    double poisson, size_z, x, z, truth, sure;  ///< computed apart from this code, and how sure that is
};

std::vector<Anchor> anchors() {
    return {
        {"2", one, 0.2, 1.0, 0.5, 0.5, 0.005612024020, 1e-9},
        {"4", one, 0.2, 1.0, 0.75, 0.75, 0.002283363, 3e-7},
        {"6, between nodes", one, 0.2, 1.0, 0.6, 0.7, 0.0038651484, 2e-8},
        {"10", [](double x, double) { return 1.0 + x; }, 0.3, 1.0, 0.5, 0.5, 0.00377153, 2e-6},
        {"11", [](double x, double) { return 4.0 / (1.0 + 3.0 * x); }, 0.2, 1.0, 0.25, 0.5, 0.00134940, 2e-6},
        {"12", [](double x, double z) { return 1.0 + 4.0 * fields::bell(x, z, 0.5, 0.5, 0.15); }, 0.2, 1.0,
         0.5, 0.5, 0.00257143, 2e-6},
        {"14", [](double x, double z) { return std::exp(x + z); }, 0.2, 0.5, 0.5, 0.25, 0.00085000, 6e-6},
    };
}

TEST_CASE("known compliances of smooth plates are met to 2e-5 from 33 and 65 nodes, wherever the load is") {
    for (const Anchor& anchor : anchors()) {
        CAPTURE(anchor.name);
        Sheet sheet = unit_sheet(anchor.rigidity, anchor.poisson);
        sheet.size_m.y() = anchor.size_z;
        const Compliance c = solved(sheet, {.at_m = {anchor.x, anchor.z}}, 65);
        CHECK(c.m_per_n == Approx(anchor.truth).epsilon(2e-5 + anchor.sure));
    }
}

TEST_CASE("the error told is never less than the true one on the known plates") {
    const Index nodes = GENERATE(as<Index>{}, 17, 33, 65);
    for (const Anchor& anchor : anchors()) {
        CAPTURE(anchor.name, nodes);
        Sheet sheet = unit_sheet(anchor.rigidity, anchor.poisson);
        sheet.size_m.y() = anchor.size_z;
        const Compliance c = solved(sheet, {.at_m = {anchor.x, anchor.z}}, nodes);
        CHECK(std::fabs(c.m_per_n / anchor.truth - 1.0) <= c.relative_error + anchor.sure);
        CHECK(c.relative_error < 0.1);
    }
}

TEST_CASE("the certified bounds hold the known compliances, and close on a uniform plate's") {
    for (const Anchor& anchor : anchors()) {
        CAPTURE(anchor.name);
        Sheet sheet = unit_sheet(anchor.rigidity, anchor.poisson);
        sheet.size_m.y() = anchor.size_z;
        const Compliance c = solved(sheet, {.at_m = {anchor.x, anchor.z}}, 33);
        REQUIRE(c.bracket_m_per_n.has_value());
        const auto [lower, upper] = *c.bracket_m_per_n;
        CHECK(lower <= anchor.truth * (1.0 + anchor.sure));
        CHECK(upper >= anchor.truth * (1.0 - anchor.sure));
        CHECK(upper / lower - 1.0 < 0.05);
    }
    const Compliance uniform = solved(unit_sheet(one), {.at_m = {0.5, 0.5}}, 33);
    CHECK((*uniform.bracket_m_per_n)[0] == Approx(0.005612024).epsilon(1e-5));
    CHECK((*uniform.bracket_m_per_n)[1] == Approx(0.005612024).epsilon(1e-5));
}

TEST_CASE("bounds answer alone when they are close enough, and say why there are none") {
    const Sheet gentle = unit_sheet([](double x, double) { return 1.0 + 0.2 * x; });
    const Load load{.at_m = {0.5, 0.5}};
    const Compliance c = compliance(gentle, {33, 33}, std::array{load}, {.tolerance = 1e-3});
    CHECK(c.method == Method::bounds);
    CHECK(c.relative_error <= 1e-3);
    CHECK(c.m_per_n == Approx(solved(gentle, load, 65).m_per_n).epsilon(1e-3));
    Sheet free = gentle;
    free.edges[1] = Edge::free;
    const Compliance none = solved(free, load, 33);
    CHECK_FALSE(none.bracket_m_per_n.has_value());
    CHECK_THAT(none.no_bracket_why, Contains("free edge"));
    CHECK_THROWS_WITH(solved(free, load, 33, Method::bounds), Contains("no bounds: with a free edge"));
    CHECK_THROWS_WITH(solved(gentle, load, 33, Method::bounds, {.points_m = {}, .field = true}),
                      Contains("compliance alone"));
}

TEST_CASE("a jump along a grid line is met to 3e-4") {
    const Sheet sheet = unit_sheet([](double x, double) { return x < 0.5 ? 1.0 : 5.0; }, 0.3);
    const Compliance c =
        solved(sheet, {.at_m = {0.25, 0.5}}, 65, Method::cholesky, {.points_m = {{0.5, 0.5}, {0.75, 0.5}}});
    CHECK(c.m_per_n == Approx(0.0027122).epsilon(3e-4));
    CHECK(c.deflection_m[0] == Approx(0.0013567).epsilon(3e-4));
    CHECK(c.deflection_m[1] == Approx(0.00034517).epsilon(3e-4));
}

TEST_CASE("deflections elsewhere are those known, and at the load the compliance times the force") {
    const Sheet sheet = unit_sheet([](double x, double) { return 4.0 / (1.0 + 3.0 * x); });
    const Compliance c = solved(sheet, {.at_m = {0.25, 0.5}, .force_n = 3.0}, 65, Method::cholesky,
                                {.points_m = {{0.5, 0.5}, {0.25, 0.5}, {0.0, 0.3}}, .field = true});
    CHECK(c.deflection_m[0] == Approx(3.0 * 0.00119703).epsilon(1e-4));
    CHECK(c.deflection_m[1] == 3.0 * c.m_per_n);
    CHECK(std::fabs(c.deflection_m[2]) < 1e-12);
    REQUIRE(c.field_m.rows() == 65);
    CHECK(c.field_m(16, 32) == Approx(c.deflection_m[1]).epsilon(1e-2));
}

TEST_CASE("loads add up, pull where they pull, and the compliance is the first one's alone") {
    const Sheet sheet = unit_sheet([](double x, double) { return 1.0 + x; });
    const Load a{.at_m = {0.5, 0.5}, .force_n = 2.0},
        b{.at_m = {0.25, 0.625}, .force_n = -1.0, .radius_m = 0.1};
    const Wanted at{.points_m = {{0.4, 0.3}}};
    const auto under = [&](std::initializer_list<Load> loads) {
        const std::vector<Load> all(loads);
        return compliance(sheet, {65, 65}, all, {.method = Method::cholesky}, at);
    };
    const Compliance both = under({a, b});
    CHECK(both.m_per_n == Approx(under({a}).m_per_n).epsilon(1e-12));
    CHECK(both.deflection_m[0] ==
          Approx(under({a}).deflection_m[0] + under({b}).deflection_m[0]).epsilon(1e-4));
}

TEST_CASE("a disc gives way as the closed form says, and less where the plate stiffens") {
    const Load disc{.at_m = {0.5, 0.5}, .radius_m = 0.1};
    // Mean over the disc and its middle, over the point's, computed apart from this code (four digits).
    const Compliance exact =
        solved(unit_sheet(one), disc, 33, Method::closed_form, {.points_m = {{0.5, 0.5}}});
    CHECK(exact.m_per_n / 0.005612024 == Approx(0.8577).epsilon(5e-4));
    CHECK(exact.deflection_m[0] / 0.005612024 == Approx(0.9141).epsilon(5e-4));
    Sheet almost = unit_sheet([](double x, double) { return 1.0 + 1e-9 * x; });
    CHECK(solved(almost, disc, 33).m_per_n == Approx(exact.m_per_n).epsilon(1e-6));
    const auto on = [&](Index nodes) {
        return solved(unit_sheet([](double x, double) { return 1.0 + x; }), disc, nodes);
    };
    CHECK(std::fabs(on(33).m_per_n / on(129).m_per_n - 1.0) < on(33).relative_error);
}

TEST_CASE("a rigid punch moves all it touches alike, and as much as known") {
    const Load punch{.at_m = {0.5, 0.5}, .radius_m = 0.1, .shape = Load::Shape::punch};
    const Compliance c = solved(unit_sheet(one), punch, 65, Method::cholesky,
                                {.points_m = {{0.5, 0.5}, {0.53125, 0.546875}}, .field = true});
    CHECK(std::fabs(c.m_per_n / (0.568 * 0.005612024) - 1.0) < c.relative_error);  // likewise
    CHECK(c.field_m(32, 32) == Approx(c.field_m(34, 35)).epsilon(1e-9));
    CHECK(c.field_m(32, 32) == Approx(c.field_m(26, 32)).epsilon(1e-9));
    CHECK(c.field_m(32, 32) > 1.01 * c.field_m(25, 32));
    CHECK_THROWS_WITH(solved(unit_sheet(one), punch, 33, Method::multigrid), Contains("many columns"));
}

TEST_CASE(
    "automatic takes the closed form where there is one, else the fewest nodes that will do, and says why") {
    const Compliance uniform = compliance(unit_sheet(one), {65, 65}, std::array{Load{.at_m = {0.3, 0.4}}});
    CHECK(uniform.method == Method::closed_form);
    CHECK_THAT(uniform.why, Contains("closed form"));
    const Sheet hill =
        unit_sheet([](double x, double z) { return 1.0 + 4.0 * fields::bell(x, z, 0.5, 0.5, 0.15); });
    const Load load{.at_m = {0.5, 0.5}};
    Index before = 0;
    for (const double tolerance : {1e-2, 1e-3, 3e-4}) {
        const Compliance c = compliance(hill, {129, 129}, std::array{load}, {.tolerance = tolerance});
        CHECK(std::fabs(c.m_per_n / 0.00257143 - 1.0) < tolerance);
        if (c.method == Method::bounds) continue;
        CHECK(c.nodes.nx >= before);
        CHECK_THAT(c.why, Contains("meets the tolerance"));
        before = c.nodes.nx;
    }
    const Compliance impossible = compliance(hill, {17, 17}, std::array{load}, {.tolerance = 1e-9});
    CHECK(impossible.relative_error > 1e-9);
    CHECK_THAT(impossible.why, Contains("above the tolerance"));
}

TEST_CASE("the error told covers jumps on grid lines, between them, and both at once") {
    const auto blocks = [](double x_jump, double z_jump) {
        return unit_sheet(
            [=](double x, double z) { return (x < x_jump ? 1.0 : 6.0) * (z < z_jump ? 1.0 : 0.1); });
    };
    const Sheet sheet = blocks(GENERATE(as<double>{}, 0.5, 0.53), GENERATE(as<double>{}, 0.625, 0.4, 0.47));
    for (const Eigen::Vector2d& at : {Eigen::Vector2d(0.25, 0.5), Eigen::Vector2d(0.31, 0.43)}) {
        CAPTURE(at.transpose());
        const Compliance coarse = solved(sheet, {.at_m = at}, 33), fine = solved(sheet, {.at_m = at}, 129);
        CHECK(std::fabs(coarse.m_per_n - fine.m_per_n) <=
              coarse.relative_error * coarse.m_per_n + fine.relative_error * fine.m_per_n);
    }
    const Problem partly = on_grid(blocks(0.5, 0.4), 33, 33);
    REQUIRE(partly.harmonic_x_n_m.size() != 0);
    CHECK((beyond_jumps(blocks(0.5, 0.4), partly, Extreme::softest) != partly.rigidity_n_m).any());
    const Problem wholly = on_grid(blocks(0.5, 0.625), 33, 33);
    CHECK((beyond_jumps(blocks(0.5, 0.625), wholly, Extreme::stiffest) == wholly.rigidity_n_m).all());
}

TEST_CASE("one grid alone is told to be as wrong as it is") {
    const Load load{.at_m = {0.5, 0.5}};
    const Sheet sheet = unit_sheet([](double x, double) { return 1.0 + x; }, 0.3);
    const Compliance raw =
        compliance(sheet, {33, 33}, std::array{load}, {.method = Method::cholesky, .extrapolate = false});
    const double error = std::fabs(raw.m_per_n / 0.00377153 - 1.0);
    CHECK(error > 1e-2);
    CHECK(raw.relative_error >= error);
    CHECK(raw.relative_error < 2.0 * error);
    const Compliance even =
        compliance(sheet, {34, 36}, std::array{load}, {.method = Method::cholesky, .extrapolate = false});
    CHECK(even.relative_error >= std::fabs(even.m_per_n / 0.00377153 - 1.0));
}

TEST_CASE("what cannot be asked is refused in words") {
    const Sheet sheet = unit_sheet([](double x, double) { return 1.0 + x; });
    const Nodes nodes{33, 33};
    const auto refused = [&](const Load& load, const Accuracy& accuracy = {}, const Wanted& wanted = {},
                             Nodes on = {33, 33}) {
        try {
            (void)compliance(sheet, on, std::array{load}, accuracy, wanted);
        } catch (const std::invalid_argument& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    const Load good{.at_m = {0.5, 0.5}};
    CHECK(refused(good).empty());
    CHECK_THAT(refused({.at_m = {1.0, 0.5}}), Contains("load at (1, 0.5) m must lie inside"));
    CHECK_THAT(refused({.at_m = {0.95, 0.5}, .radius_m = 0.1}), Contains("disc must lie inside"));
    CHECK_THAT(refused({.at_m = {0.5, 0.5}, .force_n = 0.0}), Contains("force 0 N"));
    CHECK_THAT(refused({.at_m = {0.5, 0.5}, .shape = Load::Shape::punch}), Contains("punch"));
    CHECK_THAT(refused(good, {.method = Method::closed_form}), Contains("no closed form: D is not uniform"));
    CHECK_THAT(refused(good, {.method = Method::cholesky}, {}, {34, 34}), Contains("4 m + 1"));
    CHECK_THAT(refused(good, {}, {.points_m = {{0.5, 1.1}}}), Contains("(0.5, 1.1) m lies outside"));
    CHECK_THAT(refused(good, {.tolerance = 0.0}), Contains("tolerance"));
    Sheet holed = sheet;
    holed.solid = [](double x, double) { return x > 0.4 ? -1.0 : 1.0; };
    CHECK_THROWS_WITH(compliance(holed, nodes, std::array{good}), Contains("hole"));
    CHECK_THROWS_WITH(compliance(sheet, nodes, {}), Contains("no load"));
}

}  // namespace
}  // namespace palpate::plate
