#include "host/table/bspline.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using palpate::table::spline_coefficients;

namespace {

double basis(double t) {
    t = std::abs(t);
    if (t >= 2.0) return 0.0;
    return t < 1.0 ? 2.0 / 3.0 - t * t + 0.5 * t * t * t : std::pow(2.0 - t, 3) / 6.0;
}

double value_at(const Eigen::MatrixXd& c, double x, double y) {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < c.rows(); ++i) {
        for (Eigen::Index j = 0; j < c.cols(); ++j) {
            sum += c(i, j) * basis(x - static_cast<double>(i - 1)) * basis(y - static_cast<double>(j - 1));
        }
    }
    return sum;
}

template <class F>
Eigen::MatrixXd sampled(Eigen::Index m, const F& f) {
    Eigen::MatrixXd v(m, m);
    for (Eigen::Index i = 0; i < m; ++i) {
        for (Eigen::Index j = 0; j < m; ++j) v(i, j) = f(static_cast<double>(i), static_cast<double>(j));
    }
    return v;
}

}  // namespace

TEST_CASE("the spline passes through its nodes") {
    const auto f = [](double x, double y) { return std::sin(0.7 * x) + 0.3 * y * y - x * y; };
    const Eigen::MatrixXd v = sampled(9, f), c = spline_coefficients(v);
    REQUIRE(c.rows() == 11);
    for (int i = 0; i < 9; ++i) {
        for (int j = 0; j < 9; ++j) CHECK(value_at(c, i, j) == Approx(v(i, j)).margin(1e-12));
    }
}

TEST_CASE("parabolas are exact everywhere, the rim included") {
    const auto f = [](double x, double y) {
        return 1.0 + 2.0 * x - 0.5 * x * x + 0.25 * x * y + 0.1 * y * y;
    };
    const Eigen::MatrixXd c = spline_coefficients(sampled(7, f));
    for (const double x : {0.0, 0.3, 2.5, 5.9, 6.0}) {
        for (const double y : {0.1, 3.7, 5.5}) CHECK(value_at(c, x, y) == Approx(f(x, y)).margin(1e-11));
    }
}

TEST_CASE("the spline is of fourth order for smooth values") {
    const auto worst = [](Eigen::Index m) {
        const double h = 6.0 / static_cast<double>(m - 1);
        const auto f = [&](double x, double y) {
            return std::cos(x * h - 3.0) * std::cos(0.5 * (y * h - 3.0));
        };
        const Eigen::MatrixXd c = spline_coefficients(sampled(m, f));
        double error = 0.0;
        for (double x_m = 2.0; x_m < 4.0; x_m += 0.013) {  // the same places on every grid, away from its rim
            error = std::max(error, std::abs(value_at(c, x_m / h, x_m / h) - f(x_m / h, x_m / h)));
        }
        return error;
    };
    const double order = std::log2(worst(33) / worst(65));
    CAPTURE(order);
    CHECK(order == Approx(4.0).margin(0.1));
}
