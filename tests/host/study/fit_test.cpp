#include "host/study/fit.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

namespace palpate::study {
namespace {

TEST_CASE("a power law comes back with its exponent and no error") {
    const double exponent = GENERATE(as<double>{}, -2.0, 0.0, 1.5, 4.0);
    const std::vector<double> x{17.0, 33.0, 65.0, 129.0};
    std::vector<double> y;
    for (const double v : x) y.push_back(3e-7 * std::pow(v, exponent));
    const auto law = power_law(x, y);
    REQUIRE(law);
    CHECK(law->exponent == Approx(exponent).margin(1e-12));
    CHECK(law->factor == Approx(3e-7).epsilon(1e-10));
    CHECK(law->exponent_error == Approx(0.0).margin(1e-7));
}

TEST_CASE("scatter shows in the standard error of a power law") {
    // log y = 0, 1, 0 at log x = 0, 1, 2: slope 0, residuals -1/3, 2/3, -1/3, sum of squares 2/3,
    // variance 2/3 over 3 - 2, over sum (x - 1)^2 = 2: sqrt(1/3).
    const double e = std::exp(1.0);
    const std::vector<double> x{1.0, e, e * e}, y{1.0, e, 1.0};
    const auto law = power_law(x, y);
    REQUIRE(law);
    CHECK(law->exponent == Approx(0.0).margin(1e-12));
    CHECK(law->exponent_error == Approx(std::sqrt(1.0 / 3.0)));
}

TEST_CASE("no power law goes through one point, through one grid twice, or through a time of 0") {
    const std::vector<double> one{33.0}, twice{33.0, 33.0}, two{17.0, 33.0}, times{1.0, 2.0}, zero{0.0, 1.0};
    CHECK_FALSE(power_law(one, one));
    CHECK_FALSE(power_law(twice, times));
    CHECK_FALSE(power_law(two, zero));
    CHECK_FALSE(power_law(two, one));
    CHECK_FALSE(power_law(two, times));
}

TEST_CASE("the Pareto front holds what nothing beats in time and error") {
    constexpr double NOT_KNOWN = std::numeric_limits<double>::quiet_NaN();
    const std::vector<Trade> trades{
        {1.0, 0.5},        // fastest
        {2.0, 0.6},        // beaten by the first
        {3.0, 0.1},        // on the front
        {3.0, 0.2},        // as slow, worse
        {4.0, 0.1},        // slower, as good
        {0.1, NOT_KNOWN},  // no number
        {9.0, 1e-6},       // most exact
    };
    CHECK(pareto_front(trades) == std::vector<std::size_t>{0, 2, 6});
    CHECK(pareto_front({}).empty());
}

TEST_CASE("quartiles lie between ranks") {
    const Quartiles q = quartiles({4.0, 1.0, 3.0, 2.0, 5.0});
    CHECK(q.low == 2.0);
    CHECK(q.median == 3.0);
    CHECK(q.high == 4.0);
    CHECK(quartiles({1.0, 2.0}).median == 1.5);
    CHECK(quartiles({7.0}).high == 7.0);
}

}  // namespace
}  // namespace palpate::study
