#include "host/chart/chart.hpp"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

using palpate::chart::Frame;
using palpate::chart::frame_at;
using palpate::chart::from_gnomonic;
using palpate::chart::from_plate;
using palpate::chart::gnomonic;
using palpate::chart::Projection;
using palpate::chart::to_plate;

namespace {

constexpr double radius_m = 0.03;

Frame frame(double kappa_per_m) {
    return frame_at({0.01, -0.02, 0.03}, Eigen::Vector3d(0.3, -0.5, 0.8), kappa_per_m);
}

std::vector<double> curvatures() {
    return {0.0, 1.0 / radius_m, -1.0 / radius_m, 1e-6, -1e-6, 1.0 / 0.008};
}

/// d(x, z)/d(u, v) by central differences.
Eigen::Matrix2d jacobian(const Frame& f, Projection projection, double u_m, double v_m, double step_m) {
    Eigen::Matrix2d j;
    j.col(0) = (to_plate(f, projection, u_m + step_m, v_m) - to_plate(f, projection, u_m - step_m, v_m)) /
               (2.0 * step_m);
    j.col(1) = (to_plate(f, projection, u_m, v_m + step_m) - to_plate(f, projection, u_m, v_m - step_m)) /
               (2.0 * step_m);
    return j;
}

/// Area of the sphere for one of the gnomonic plane, cos^3 of the angle from the contact.
double area_ratio(double kappa_per_m, double u_m, double v_m) {
    const double square = 1.0 + kappa_per_m * kappa_per_m * (u_m * u_m + v_m * v_m);
    return 1.0 / (square * std::sqrt(square));
}

}  // namespace

TEST_CASE("a frame is right-handed and orthonormal, and puts places where they were") {
    const Frame f = frame(20.0);
    REQUIRE((f.axes * f.axes.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-15);
    REQUIRE(f.axes.determinant() == Approx(1.0).epsilon(1e-14));
    REQUIRE((f.axes.row(2).transpose() - Eigen::Vector3d(0.3, -0.5, 0.8).normalized()).norm() < 1e-15);
    const Eigen::Vector3d at(0.011, -0.018, 0.027);
    REQUIRE((f.world_m(f.local_m(at)) - at).norm() < 1e-17);
    REQUIRE((f.local_m(f.origin_m)).norm() == 0.0);
}

TEST_CASE("the first axis follows the world's x, and the world's z within 10 degrees of it") {
    const double degree = M_PI / 180.0;
    const double from_x = GENERATE(as<double>{}, 0.0, 9.9, 10.1, 45.0, 90.0, 169.9, 170.1, 180.0);
    const Eigen::Vector3d e3(std::cos(from_x * degree), std::sin(from_x * degree), 0.0);
    const Frame f = frame_at(Eigen::Vector3d::Zero(), e3, 0.0);
    const bool takes_z = from_x < 10.0 || from_x > 170.0;
    const Eigen::Vector3d world = takes_z ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
    CAPTURE(from_x);
    const Eigen::Vector3d tangent = (world - world.dot(e3) * e3).normalized();
    REQUIRE((f.axes.row(0).transpose() - tangent).norm() < 1e-14);
}

TEST_CASE("gnomonic coordinates and height go there and back, on convex, concave and flat") {
    for (const double kappa : curvatures()) {
        const Frame f = frame(kappa);
        for (const double u : {-0.004, 0.0, 0.0055}) {
            for (const double v : {-0.006, 0.0, 0.003}) {
                for (const double height : {-0.003, 0.0, 0.002}) {
                    const auto back = gnomonic(f, from_gnomonic(f, u, v, height));
                    CAPTURE(kappa, u, v, height);
                    REQUIRE(back);
                    REQUIRE((*back - Eigen::Vector3d(u, v, height)).norm() < 1e-16);
                }
            }
        }
    }
}

TEST_CASE("the height is the distance from the sphere along its own radius") {
    const double kappa = GENERATE(as<double>{}, 1.0 / radius_m, -1.0 / radius_m);
    const Frame f = frame(kappa);
    const Eigen::Vector3d centre(0.0, 0.0, -1.0 / kappa);
    const Eigen::Vector3d x(0.004, -0.003, 0.0015);
    const double sign = kappa > 0.0 ? 1.0 : -1.0;
    const double truth = sign * (x - centre).norm() - 1.0 / kappa;
    const auto g = gnomonic(f, x);
    REQUIRE(g);
    REQUIRE(g->z() == Approx(truth).epsilon(1e-12));
    // The ray from the centre through x meets the tangent plane at (u, v).
    const Eigen::Vector3d ray = centre - (x - centre) * (centre.z() / (x - centre).z());
    REQUIRE((ray - Eigen::Vector3d(g->x(), g->y(), 0.0)).norm() < 1e-16);
}

TEST_CASE("a place past the centre or on the far side has no gnomonic coordinates") {
    const Frame convex = frame(1.0 / radius_m);
    REQUIRE_FALSE(gnomonic(convex, {0.0, 0.0, -0.81 * radius_m}));
    REQUIRE(gnomonic(convex, {0.0, 0.0, -0.79 * radius_m}));
    REQUIRE_FALSE(gnomonic(frame(-1.0 / radius_m), {0.0, 0.0, 0.81 * radius_m}));
    REQUIRE_FALSE(gnomonic(frame(0.0), {0.0, 0.0, std::nan("")}));
}

TEST_CASE("both projections go there and back") {
    const Projection projection = GENERATE(Projection::azimuthal, Projection::gall_peters);
    for (const double kappa : curvatures()) {
        const Frame f = frame(kappa);
        for (const double u : {-0.02, -1e-7, 0.0, 0.006}) {
            for (const double v : {-0.015, 0.0, 1e-7, 0.009}) {
                const Eigen::Vector2d plate = to_plate(f, projection, u, v);
                const auto back = from_plate(f, projection, plate);
                CAPTURE(kappa, u, v);
                REQUIRE(back);
                REQUIRE((*back - Eigen::Vector2d(u, v)).norm() < 1e-16);
            }
        }
    }
}

TEST_CASE("both projections keep areas everywhere") {
    const Projection projection = GENERATE(Projection::azimuthal, Projection::gall_peters);
    for (const double kappa : curvatures()) {
        const Frame f = frame(kappa);
        for (const double u : {-0.02, 0.0, 0.006}) {
            for (const double v : {-0.015, 0.0, 0.009}) {
                const double ratio =
                    jacobian(f, projection, u, v, 1e-6).determinant() / area_ratio(kappa, u, v);
                CAPTURE(kappa, u, v);
                REQUIRE(ratio == Approx(1.0).epsilon(1e-6));  // the differences' own error is 1e-8
            }
        }
    }
}

TEST_CASE("Lambert is isometric at the contact, Gall-Peters stretches 2 to 1 there") {
    for (const double kappa : curvatures()) {
        const Frame f = frame(kappa);
        CAPTURE(kappa);
        const Eigen::Matrix2d lambert = jacobian(f, Projection::azimuthal, 0.0, 0.0, 1e-7);
        REQUIRE((lambert - Eigen::Matrix2d::Identity()).norm() < 1e-8);
        const Eigen::Matrix2d gall = jacobian(f, Projection::gall_peters, 0.0, 0.0, 1e-7);
        REQUIRE(gall(0, 1) == Approx(0.0).margin(1e-12));
        REQUIRE(gall(1, 0) == Approx(0.0).margin(1e-12));
        REQUIRE(gall(1, 1) / gall(0, 0) == Approx(2.0).epsilon(1e-8));
        REQUIRE(gall(0, 0) == Approx(1.0 / std::sqrt(2.0)).epsilon(1e-8));
    }
}

TEST_CASE("Lambert lays an arc of angle t at 2 R sin(t/2), Gall-Peters longitude and latitude as in eq. 4") {
    const double t = 0.7;
    const double kappa = 1.0 / radius_m;
    const Frame f = frame(kappa);
    const double along = std::tan(t) * radius_m;
    REQUIRE(to_plate(f, Projection::azimuthal, along, 0.0).x() ==
            Approx(2.0 * radius_m * std::sin(t / 2.0)).epsilon(1e-14));
    REQUIRE(to_plate(f, Projection::gall_peters, along, 0.0).x() ==
            Approx(radius_m * t / std::sqrt(2.0)).epsilon(1e-14));
    REQUIRE(to_plate(f, Projection::gall_peters, 0.0, along).y() ==
            Approx(radius_m * std::sqrt(2.0) * std::sin(t)).epsilon(1e-14));
}

TEST_CASE("the sine, tangent and arc tangent in Gall-Peters hold to the last digits at every angle") {
    const Frame f = frame(1.0);  // R = 1 m: u is the tangent of the longitude
    for (int i = -155; i <= 155; ++i) {
        const double longitude = 0.01 * i;
        const double u = std::tan(longitude);
        CAPTURE(longitude);
        const Eigen::Vector2d plate = to_plate(f, Projection::gall_peters, u, 0.0);
        REQUIRE(plate.x() == Approx(std::atan(u) / std::sqrt(2.0)).epsilon(2e-15).margin(1e-300));
        const auto back = from_plate(f, Projection::gall_peters, plate);
        REQUIRE(back);
        // tan amplifies the rounding of its argument by (1 + u^2)/u.
        REQUIRE(back->x() == Approx(u).epsilon(1e-15 * (2.0 + 2.0 * std::fabs(u))).margin(1e-300));
    }
}

TEST_CASE("plate coordinates pass continuously through the plane") {
    const Projection projection = GENERATE(Projection::azimuthal, Projection::gall_peters);
    const Eigen::Vector2d flat = to_plate(frame(0.0), projection, 0.013, -0.008);
    const bool gall = projection == Projection::gall_peters;
    const Eigen::Vector2d truth = gall ? Eigen::Vector2d(0.013 / std::sqrt(2.0), -0.008 * std::sqrt(2.0))
                                       : Eigen::Vector2d(0.013, -0.008);
    REQUIRE((flat - truth).norm() < 1e-17);
    double previous = 1.0;
    for (const double kappa : {10.0, 1.0, 0.1, 0.01, 1e-4, 1e-9, 1e-200}) {
        // Both signs give the same plate: only kappa squared enters, and the difference falls with it.
        const Eigen::Vector2d convex = to_plate(frame(kappa), projection, 0.013, -0.008);
        const Eigen::Vector2d concave = to_plate(frame(-kappa), projection, 0.013, -0.008);
        CAPTURE(kappa);
        REQUIRE((convex - concave).norm() == 0.0);
        const double change = (convex - flat).norm();
        REQUIRE(change <= kappa * kappa * 4e-6 + 1e-17);
        REQUIRE(change <= previous);
        previous = change;
    }
}

TEST_CASE("plate coordinates outside the hemisphere have no inverse") {
    const Frame f = frame(-1.0 / radius_m);
    const double rim = std::sqrt(2.0) * radius_m;  // Lambert's circle of the hemisphere
    REQUIRE(from_plate(f, Projection::azimuthal, {0.999 * rim, 0.0}));
    REQUIRE_FALSE(from_plate(f, Projection::azimuthal, {1.001 * rim, 0.0}));
    const double east = radius_m * M_PI / 2.0 / std::sqrt(2.0);
    REQUIRE(from_plate(f, Projection::gall_peters, {0.999 * east, 0.0}));
    REQUIRE_FALSE(from_plate(f, Projection::gall_peters, {1.001 * east, 0.0}));
    REQUIRE(from_plate(f, Projection::gall_peters, {0.0, 0.999 * rim}));
    REQUIRE_FALSE(from_plate(f, Projection::gall_peters, {0.0, 1.001 * rim}));
    REQUIRE_FALSE(from_plate(f, Projection::azimuthal, {std::nan(""), 0.0}));
}
