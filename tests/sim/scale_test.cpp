// A simulated delta of another size, against the closed forms of its own lengths.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "sim/falcon/falcon_sim.h"

namespace {

constexpr double kPi = 3.14159265358979323846;
using Point = std::array<double, 3>;

/// Stamper's inverse kinematics (docs/PROTOCOL.md 4) of a Falcon with all lengths times `scale`, in rad.
Point closed_form_rad(double scale, const Point& at_m) {
    const double a = 0.060 * scale;
    const double b = 0.1025 * scale;
    const double d_e = 0.0225 * scale;
    const std::array<double, 3> legs = {105, -15, -135};
    Point theta{};
    for (std::size_t i = 0; i < 3; ++i) {
        const double phi = legs[i] * kPi / 180;
        const double u = at_m[0] * std::cos(phi) + at_m[1] * std::sin(phi) + (0.01443 - 0.0400) * scale;
        const double v = at_m[1] * std::cos(phi) - at_m[0] * std::sin(phi) + (0.02309 - 0.025) * scale;
        const double k = d_e + std::sqrt(b * b - v * v);
        const double rho = std::hypot(u, at_m[2]);
        theta[i] = std::atan2(at_m[2], u) - std::acos((rho * rho + a * a - k * k) / (2 * a * rho));
    }
    return theta;
}

int counts_of(double theta_rad) {
    return static_cast<int>(std::lround((theta_rad - 35 * kPi / 180) * 1572.5625));
}

pal_falcon_sim_config config_at(double scale, const Point& at_m) {
    pal_falcon_sim_config config = pal_falcon_sim_config_default();
    pal_falcon_sim_resize(&config, scale);
    for (std::size_t i = 0; i < 3; ++i) config.start_m[i] = at_m[i];
    for (int16_t& offset : config.start_offset_counts) offset = 0;
    return config;
}

Point times(double scale, Point point) {
    for (double& x : point) x *= scale;
    return point;
}

}  // namespace

TEST_CASE("encoders and motors of a delta of another size are those of its own lengths") {
    const double scale = GENERATE(as<double>{}, 0.25, 0.7, 1, 1.5, 4);
    const Point at_m = times(scale, GENERATE(as<Point>{}, Point{0, 0, 0.11}, Point{0.02, 0.01, 0.12},
                                             Point{-0.03, 0.02, 0.10}, Point{0.03, -0.03, 0.14}));
    const pal_falcon_sim_config config = config_at(scale, at_m);
    pal_falcon_sim sim;
    REQUIRE(pal_falcon_sim_init(&sim, &config));
    std::array<int16_t, 3> read{};
    pal_falcon_sim_read(&sim, read.data());
    const Point theta = closed_form_rad(scale, at_m);
    for (std::size_t i = 0; i < 3; ++i) CHECK(read[i] == counts_of(theta[i]));

    const std::array<int16_t, 3> words = {900, -400, 250};
    Point force_n{};
    REQUIRE(pal_falcon_sim_motor_force(&config, at_m.data(), words.data(), force_n.data()));
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double h = 1e-6 * scale;
        Point up = at_m;
        Point down = at_m;
        up[axis] += h;
        down[axis] -= h;
        const Point theta_up = closed_form_rad(scale, up);
        const Point theta_down = closed_form_rad(scale, down);
        double virtual_work_n = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            virtual_work_n -= words[i] / 4200.0 * (theta_up[i] - theta_down[i]) / (2 * h);
        }
        CHECK(force_n[axis] == Approx(virtual_work_n).margin(1e-7 / scale));  // of the central difference
    }
}

TEST_CASE("a delta that was resized starts in its middle, also when it is resized once more") {
    pal_falcon_sim_config config = pal_falcon_sim_config_default();
    pal_falcon_sim_resize(&config, 3.0);
    CHECK(config.start_m[2] == Approx(0.36));
    pal_falcon_sim_resize(&config, 0.5);
    CHECK(config.start_m[2] == Approx(0.06));
    CHECK(config.scale == 0.5);
    pal_falcon_sim sim;
    CHECK(pal_falcon_sim_init(&sim, &config));
}

TEST_CASE("a hand that pushes into the stops finds them as hard, whatever the delta's size") {
    const auto depth_m = [](double scale, double towards) {
        const pal_falcon_sim_config config = config_at(scale, {0, 0, 0.12 * scale});
        pal_falcon_sim sim;
        REQUIRE(pal_falcon_sim_init(&sim, &config));
        const auto push = [](const void* context, const double*, const double*, double* force_n) {
            force_n[0] = 0;
            force_n[1] = 0.2 * 9.81;  // the weight
            force_n[2] = *static_cast<const double*>(context);
        };
        const double lightly = 2 * towards;
        const double hard = 20 * towards;
        for (int i = 0; i < 3000; ++i) pal_falcon_sim_advance(&sim, push, &lightly, 0);
        const double touched_m = sim.position_m[2];
        for (int i = 0; i < 1000; ++i) {
            pal_falcon_sim_advance(&sim, push, &hard, 0);
            for (const double v : sim.velocity_m_per_s) REQUIRE(std::fabs(v) < 1.0);
        }
        return towards * (sim.position_m[2] - touched_m);
    };
    const double towards = GENERATE(as<double>{}, -1, 1);
    const double falcon_m = depth_m(1, towards);
    CHECK(falcon_m > 5e-6);
    for (const double scale : {0.25, 4.0}) CHECK(depth_m(scale, towards) == Approx(falcon_m).epsilon(0.05));
}

TEST_CASE("a size out of range is refused") {
    const double scale = GENERATE(as<double>{}, 0, -1, 0.2, 4.1, NAN, INFINITY);
    pal_falcon_sim_config config = pal_falcon_sim_config_default();
    config.scale = scale;
    pal_falcon_sim sim;
    CHECK_FALSE(pal_falcon_sim_init(&sim, &config));
}
