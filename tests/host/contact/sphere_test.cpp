#include "host/contact/sphere.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

using palpate::contact::fit_sphere;
using palpate::contact::Sphere;

namespace {

using Points = std::vector<Eigen::Vector3d>;

double uniform(std::mt19937& random) {
    return static_cast<double>(random()) / 4294967296.0;
}

double gauss(std::mt19937& random) {  // Irwin-Hall: bounded, the same on every library
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += uniform(random);
    return sum;
}

/// Points of a cap of half-angle `angle_rad` about +z of a sphere through the origin; kappa < 0: a bowl seen
/// from above.
Points cap(double kappa_per_m, double size_m, int n, double noise_m, unsigned seed) {
    std::mt19937 random(seed);
    Points points;
    while (static_cast<int>(points.size()) < n) {
        const double x = size_m * (2.0 * uniform(random) - 1.0);
        const double y = size_m * (2.0 * uniform(random) - 1.0);
        const double square = x * x + y * y;
        if (square > size_m * size_m) continue;
        const double z = -kappa_per_m * square / (1.0 + std::sqrt(1.0 - kappa_per_m * kappa_per_m * square));
        const Eigen::Vector3d normal(kappa_per_m * x, kappa_per_m * y, 1.0 + kappa_per_m * z);
        const Eigen::Vector3d shift(0.1, -0.2, 0.3);  // nothing may depend on the world's origin
        points.push_back(Eigen::Vector3d(x, y, z) + noise_m * gauss(random) * normal + shift);
    }
    return points;
}

const Eigen::Vector3d apex(0.1, -0.2, 0.3);

Sphere fit(const Points& points, const Eigen::Vector3d& outward = Eigen::Vector3d::UnitZ()) {
    return fit_sphere(points, std::vector<double>(points.size(), 1.0), outward);
}

/// Kasa's fit: least squares of |x|^2 + b.x + c, without the constraint of eq. 1.
double kasa_radius_m(const Points& points) {
    Eigen::MatrixXd a(static_cast<Eigen::Index>(points.size()), 4);
    Eigen::VectorXd rhs(a.rows());
    for (Eigen::Index i = 0; i < a.rows(); ++i) {
        const Eigen::Vector3d x = points[static_cast<std::size_t>(i)] - apex;
        a.row(i) << x.x(), x.y(), x.z(), 1.0;
        rhs(i) = -x.squaredNorm();
    }
    const Eigen::VectorXd b = a.colPivHouseholderQr().solve(rhs);
    return std::sqrt(0.25 * b.head<3>().squaredNorm() - b(3));
}

/// sum w F^2 of a fit.
double cost(const Sphere& s, const Points& points, const std::vector<double>& weights) {
    double sum = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector3d x = points[i] - s.origin_m;
        const double f = s.u(0) * x.squaredNorm() + s.u.segment<3>(1).dot(x) + s.u(4);
        sum += weights[i] * f * f;
    }
    return sum;
}

double constraint(const Eigen::Matrix<double, 5, 1>& u) {
    return u.segment<3>(1).squaredNorm() - 4.0 * u(0) * u(4);
}

}  // namespace

TEST_CASE("a fit to points on a sphere, a bowl or a plane is that surface") {
    const double kappa = GENERATE(as<double>{}, 1.0 / 0.03, -1.0 / 0.03, 1.0 / 0.008, 0.0, 1e-5);
    const int n = GENERATE(as<int>{}, 5, 40, 200);  // the last takes several blocks of rows
    const Points points = cap(kappa, 0.004, n, 0.0, 7);
    const Sphere s = fit(points);
    CAPTURE(kappa, n);
    // Five random points see a cap of 4 mm no better than one part in 1e3 of its sag, so the digits go there.
    const double digits = n == 5 ? 1e-10 : 1e-12;
    REQUIRE(s.kappa_per_m() == Approx(kappa).epsilon(digits).margin(250.0 * digits));
    REQUIRE(constraint(s.u) == Approx(1.0).epsilon(1e-14));
    for (const Eigen::Vector3d& p : points) REQUIRE(std::fabs(s.distance_m(p)) < 1e-14);
    REQUIRE((s.normal(apex) - Eigen::Vector3d::UnitZ()).norm() < digits);
}

TEST_CASE("the signed distance and the projection are the sphere's own, near and far") {
    const double kappa = GENERATE(as<double>{}, 1.0 / 0.03, -1.0 / 0.03);
    const Sphere s = fit(cap(kappa, 0.02, 100, 0.0, 3));
    const Eigen::Vector3d centre = apex - Eigen::Vector3d(0.0, 0.0, 1.0 / kappa);
    const double sign = kappa > 0.0 ? 1.0 : -1.0;
    for (const Eigen::Vector3d& x :
         {Eigen::Vector3d(0.101, -0.203, 0.302), Eigen::Vector3d(0.15, -0.16, 0.28),
          Eigen::Vector3d(0.098, -0.2, 0.293), Eigen::Vector3d(1.0, 2.0, 3.0)}) {
        const double truth = sign * ((x - centre).norm() - 0.03);
        REQUIRE(s.distance_m(x) == Approx(truth).epsilon(1e-12).margin(1e-14));
        REQUIRE((s.normal(x) - sign * (x - centre).normalized()).norm() < 1e-11);
        REQUIRE(std::fabs((s.project(x) - centre).norm() - 0.03) < 1e-12);
    }
}

TEST_CASE("curvature and distance pass continuously through the plane") {
    const Eigen::Vector3d at = apex + Eigen::Vector3d(0.001, 0.002, 0.0015);
    const double flat = fit(cap(0.0, 0.004, 50, 0.0, 5)).distance_m(at);
    REQUIRE(flat == Approx(0.0015).epsilon(1e-13));
    for (int exponent = 1; exponent > -14; --exponent) {
        double kappa = 1.0;
        for (int i = 0; i < std::abs(exponent); ++i) kappa = exponent > 0 ? kappa * 10.0 : kappa / 10.0;
        for (const double k : {kappa, -kappa}) {
            const Sphere s = fit(cap(k, 0.004, 50, 0.0, 5));
            CAPTURE(k);
            REQUIRE(s.kappa_per_m() == Approx(k).epsilon(1e-11).margin(1e-10));
            // |at|^2/2 along the curvature, to first order.
            REQUIRE(std::fabs(s.distance_m(at) - flat) < std::fabs(k) * 4e-6 + 1e-15);
        }
    }
}

TEST_CASE("the radius of a noisy cap is right within 2 % where Kasa's fit is far too small") {
    const double radius = 0.03;
    double pratt = 0.0;
    double kasa = 0.0;
    const int n_trials = 50;
    for (unsigned trial = 0; trial < n_trials; ++trial) {
        const Points points = cap(1.0 / radius, 0.006, 400, 1e-4, 100 + trial);  // a sixth of the sag
        pratt += fit(points).kappa_per_m() / n_trials;
        kasa += 1.0 / kasa_radius_m(points) / n_trials;
    }
    const double pratt_error = std::fabs(pratt * radius - 1.0);
    const double kasa_error = std::fabs(kasa * radius - 1.0);
    CAPTURE(pratt_error, kasa_error);
    REQUIRE(pratt_error < 0.02);
    REQUIRE(kasa_error > 0.05);
}

TEST_CASE("no nearby sphere that meets the constraint has a smaller weighted cost") {
    std::mt19937 random(11);
    const Points points = cap(1.0 / 0.02, 0.005, 60, 2e-4, 12);
    std::vector<double> weights;
    for (std::size_t i = 0; i < points.size(); ++i) weights.push_back(uniform(random));
    const Sphere s = fit_sphere(points, weights, Eigen::Vector3d::UnitZ());
    const double least = cost(s, points, weights);
    for (int i = 0; i < 200; ++i) {
        Sphere other = s;
        const double step = i < 100 ? 1e-3 : 1e-1;
        const double unit_m = 0.003;
        other.u(0) += step * gauss(random) / unit_m;
        other.u(1) += step * gauss(random);
        other.u(2) += step * gauss(random);
        other.u(3) += step * gauss(random);
        other.u(4) += step * gauss(random) * unit_m;
        if (!(constraint(other.u) > 0.0)) continue;
        other.u /= std::sqrt(constraint(other.u));
        REQUIRE(cost(other, points, weights) >= least);
    }
}

TEST_CASE("a weight of two is the same as the point twice, and a weight of zero as no point") {
    const Points points = cap(1.0 / 0.02, 0.005, 30, 2e-4, 21);
    Points twice = points;
    std::vector<double> weights(points.size(), 1.0);
    weights[4] = 2.0;
    twice.push_back(points[4]);
    Points with_stray = points;
    with_stray.emplace_back(1.0, 1.0, 1.0);
    std::vector<double> zero_last = weights;
    zero_last.push_back(0.0);
    const Sphere a = fit_sphere(points, weights, Eigen::Vector3d::UnitZ());
    const Sphere b = fit(twice);
    const Sphere c = fit_sphere(with_stray, zero_last, Eigen::Vector3d::UnitZ());
    const Eigen::Vector3d at = apex + Eigen::Vector3d(0.002, 0.001, 0.003);
    REQUIRE(a.kappa_per_m() == Approx(b.kappa_per_m()).epsilon(1e-12));
    REQUIRE(a.distance_m(at) == Approx(b.distance_m(at)).epsilon(1e-12));
    REQUIRE(c.u == a.u);
    // And weights matter at all.
    REQUIRE(std::fabs(a.kappa_per_m() - fit(points).kappa_per_m()) > 1e-3);
}

TEST_CASE("the order of the points does not matter, nor does a motion of all of them") {
    Points points = cap(-1.0 / 0.02, 0.005, 80, 2e-4, 31);
    const Sphere a = fit(points);
    const Eigen::Vector3d at = apex + Eigen::Vector3d(0.002, 0.001, 0.003);
    const double distance = a.distance_m(at);
    std::reverse(points.begin(), points.end());
    std::swap(points[3], points[40]);
    REQUIRE(fit(points).kappa_per_m() == Approx(a.kappa_per_m()).epsilon(1e-11));
    REQUIRE(fit(points).distance_m(at) == Approx(distance).epsilon(1e-11));

    const Eigen::Matrix3d turn = Eigen::Quaterniond(0.3, -0.5, 0.7, 0.2).normalized().toRotationMatrix();
    for (Eigen::Vector3d& p : points) p = turn * p + Eigen::Vector3d(1.0, -2.0, 0.5);
    const Sphere moved = fit(points, turn.col(2));
    REQUIRE(moved.kappa_per_m() == Approx(a.kappa_per_m()).epsilon(1e-10));
    REQUIRE(moved.distance_m(turn * at + Eigen::Vector3d(1.0, -2.0, 0.5)) == Approx(distance).epsilon(1e-10));
}

TEST_CASE("the outward direction chooses the sign, and a closed ball is an object") {
    const Points points = cap(1.0 / 0.03, 0.004, 40, 0.0, 7);
    const Sphere up = fit(points);
    const Sphere down = fit(points, -Eigen::Vector3d::UnitZ());
    REQUIRE(down.u == -up.u);
    REQUIRE(down.kappa_per_m() == Approx(-1.0 / 0.03).epsilon(1e-12));

    Points ball;
    for (const double s : {-1.0, 1.0}) {
        for (int axis = 0; axis < 3; ++axis) ball.push_back(0.02 * s * Eigen::Vector3d::Unit(axis));
    }
    REQUIRE(fit(ball).kappa_per_m() == Approx(50.0).epsilon(1e-12));
}

TEST_CASE("the centre is -(u1 u2 u3)/(2 u0) and the radius sqrt(c.c - u4/u0), not as eq. 3 is printed") {
    const double radius = 0.03;
    const Sphere s = fit(cap(1.0 / radius, 0.01, 100, 0.0, 3));
    const Eigen::Vector3d truth = apex - Eigen::Vector3d(0.0, 0.0, radius) - s.origin_m;
    const Eigen::Vector3d centre = -s.u.segment<3>(1) / (2.0 * s.u(0));
    REQUIRE((centre - truth).norm() < 1e-13);
    REQUIRE(std::sqrt(centre.squaredNorm() - s.u(4) / s.u(0)) == Approx(radius).epsilon(1e-12));

    const Eigen::Vector3d printed = -s.u.segment<3>(1) / (2.0 * s.u(4));
    const double printed_square = printed.squaredNorm() - s.u(0) / s.u(4);
    REQUIRE((printed - truth).norm() > radius);
    REQUIRE(std::fabs(std::sqrt(std::fabs(printed_square)) - radius) > radius);
}

TEST_CASE("fewer than four weighted points, or all of them in one place, are refused") {
    Points points = cap(0.0, 0.004, 4, 0.0, 1);
    std::vector<double> weights(4, 1.0);
    REQUIRE_NOTHROW(fit_sphere(points, weights, Eigen::Vector3d::UnitZ()));
    weights[2] = 0.0;
    REQUIRE_THROWS_AS(fit_sphere(points, weights, Eigen::Vector3d::UnitZ()), std::invalid_argument);
    weights.pop_back();
    REQUIRE_THROWS_AS(fit_sphere(points, weights, Eigen::Vector3d::UnitZ()), std::invalid_argument);
    REQUIRE_THROWS_AS(fit(Points(6, apex)), std::invalid_argument);
}
