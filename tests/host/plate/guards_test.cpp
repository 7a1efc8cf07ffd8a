#include <catch2/catch.hpp>
#include <limits>
#include <string>
#include <vector>

#include "host/plate/plate.hpp"
#include "tests/host/plate/fields.hpp"

namespace palpate::plate {
namespace {

using Catch::Matchers::Contains;
using namespace fields;

constexpr double NOT_A_NUMBER = std::numeric_limits<double>::quiet_NaN();
constexpr double INFINITE = std::numeric_limits<double>::infinity();

TEST_CASE("a good plate has nothing wrong with it") {
    CHECK_FALSE(problem_with(unit_square(17, hyper10)).has_value());
    CHECK_FALSE(problem_with(on_foundation(unit_square(17, hyper10), 0.0)).has_value());
}

TEST_CASE("a rigidity that is not positive and finite is refused, with its node") {
    const double bad = GENERATE(as<double>{}, 0.0, -0.5, -0.0, NOT_A_NUMBER, INFINITE, -INFINITE);
    Problem problem = unit_square(17, one);
    problem.rigidity_n_m(3, 11) = bad;
    REQUIRE(problem_with(problem).has_value());
    CHECK_THAT(*problem_with(problem),
               Contains("rigidity") && Contains("node (3, 11)") && Contains("positive"));
    CHECK_THROWS_AS(Plate(problem), std::invalid_argument);
    CHECK_THROWS_AS(extrapolated_centre_compliance(problem), std::invalid_argument);
}

TEST_CASE("a foundation that is negative or not finite is refused, with its node") {
    const double bad = GENERATE(as<double>{}, -1e-9, NOT_A_NUMBER, INFINITE);
    Problem problem = on_foundation(unit_square(17, one), 3.0);
    problem.foundation_n_per_m3(0, 16) = bad;
    REQUIRE(problem_with(problem).has_value());
    CHECK_THAT(*problem_with(problem), Contains("foundation") && Contains("node (0, 16)"));
    CHECK_THROWS_AS(Plate(problem), std::invalid_argument);
}

TEST_CASE("wrong sizes are refused in words") {
    Problem problem = unit_square(17, one);
    SECTION("side not positive") {
        problem.size_m.y() = GENERATE(as<double>{}, 0.0, -0.04, NOT_A_NUMBER, INFINITE);
        CHECK_THAT(problem_with(problem).value_or(""), Contains("plate sides"));
    }
    SECTION("too few nodes") {
        problem.rigidity_n_m = Eigen::ArrayXXd::Ones(4, 17);
        CHECK_THAT(problem_with(problem).value_or(""), Contains("4 x 17 nodes; needs at least 5 x 5"));
    }
    SECTION("no nodes") {
        problem.rigidity_n_m.resize(0, 0);
        CHECK_THAT(problem_with(problem).value_or(""), Contains("0 x 0 nodes"));
    }
    SECTION("foundation of another size") {
        problem.foundation_n_per_m3 = Eigen::ArrayXXd::Ones(17, 16);
        CHECK_THAT(problem_with(problem).value_or(""), Contains("17 x 16") && Contains("17 x 17"));
    }
    SECTION("Poisson's ratio") {
        problem.poisson = GENERATE(as<double>{}, -1.0, 0.5, 2.0, NOT_A_NUMBER);
        CHECK_THAT(problem_with(problem).value_or(""), Contains("Poisson"));
    }
    CHECK_THROWS_AS(Plate(problem), std::invalid_argument);
}

TEST_CASE("no extrapolation without a second grid, no centre without a node there") {
    Problem problem = unit_square(19, one);
    CHECK_THROWS_WITH(extrapolated_centre_compliance(problem), Contains("4 m + 1"));
    CHECK_THROWS_WITH(extrapolated_centre_compliance(unit_square(5, one)), Contains("at least 9"));
    problem.rigidity_n_m = Eigen::ArrayXXd::Ones(18, 19);
    CHECK_THROWS_WITH(Plate(problem).centre_compliance_m_per_n(), Contains("must be odd"));
    CHECK_THROWS_WITH(Plate(problem).deflection_m(18, 0), Contains("outside the grid"));
}

TEST_CASE("a stiff island that double cannot resolve is refused, one that it can is not") {
    // The island's rigid motions are as soft as its surroundings: pivot ratio about 3/ratio.
    const auto island = [](double ratio) {
        return unit_square(
            33, [=](double x, double z) { return x > 0.3 && x < 0.7 && z > 0.3 && z < 0.7 ? ratio : 1.0; });
    };
    CHECK_NOTHROW(Plate(island(1e3)));
    CHECK_NOTHROW(Plate(island(1e6)));
    CHECK_THROWS_AS(Plate(island(1e9)), Guard);
    CHECK_THROWS_WITH(Plate(island(1e12)), Contains("pivot"));
    CHECK_THROWS_AS(extrapolated_centre_compliance(island(1e12)), Guard);
}

TEST_CASE("a rigidity that spans more than double's digits is refused") {
    CHECK_THAT(
        problem_with(unit_square(17, [](double x, double) { return x > 0.4 ? 1e16 : 1.0; })).value_or(""),
        Contains("15 decades"));
}

}  // namespace
}  // namespace palpate::plate
