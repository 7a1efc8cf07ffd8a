#include "sim/falcon/kinematics.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "sim/falcon/falcon_sim.h"

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kDegrees = 180.0 / kPi;

/// Facts of docs/PROTOCOL.md 4, computed elsewhere from Stamper's closed forms.
struct Fact {
    std::array<double, 3> at_m, theta_deg;
    std::array<int, 3> counts;
    std::array<double, 3> torque_n_m;  ///< for 1, 2, 3 N
};

const std::array<Fact, 8> kFacts{{
    {{0, 0, 0.08}, {-11.8, -11.8, -11.8}, {-1284, -1284, -1284}, {-0.009027, 0.029892, 0.121700}},
    {{0, 0, 0.11}, {16.1880, 16.1880, 16.1880}, {-516, -516, -516}, {-0.015851, 0.044930, 0.188543}},
    {{0, 0, 0.125}, {27.7093, 27.7093, 27.7093}, {-200, -200, -200}, {-0.025674, 0.043789, 0.209069}},
    {{0, 0, 0.15}, {47.2433, 47.2433, 47.2433}, {336, 336, 336}, {-0.049491, 0.030133, 0.224269}},
    {{0.02, 0.01, 0.12}, {23.8701, 14.8169, 38.5990}, {-305, -554, 99}, {-0.013034, 0.077120, 0.182153}},
    {{-0.03, 0.02, 0.10}, {-7.7440, 37.6494, 10.5818}, {-1173, 73, -670}, {0.036689, -0.028869, 0.178149}},
    {{0.03, -0.03, 0.14}, {65.1884, 25.1500, 47.2175}, {829, -270, 335}, {-0.164374, 0.105944, 0.240243}},
    {{0, 0.04, 0.11}, {-4.9240, 30.6493, 42.2503}, {-1096, -119, 199}, {0.065850, 0.023125, 0.160859}},
}};

std::array<double, 3> random_point(std::mt19937_64& random) {
    const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    return {0.12 * unit() - 0.06, 0.12 * unit() - 0.06, 0.07 + 0.11 * unit()};
}

}  // namespace

TEST_CASE("own sine and cosine agree with libm to two units in the last place of 1") {
    for (int i = -3000; i <= 3000; ++i) {
        const double angle = kPi * i / 3000.0;
        double s = 0;
        double c = 0;
        pal_falcon_sin_cos(angle, &s, &c);
        CHECK(std::fabs(s - std::sin(angle)) <= 2.3e-16);
        CHECK(std::fabs(c - std::cos(angle)) <= 2.3e-16);
    }
}

TEST_CASE("arm angles, encoder readings and virtual work meet the published facts") {
    const auto& fact = kFacts[GENERATE(as<std::size_t>{}, 0, 1, 2, 3, 4, 5, 6, 7)];
    double theta[3];
    int16_t counts[3];
    double j[9];
    REQUIRE(pal_falcon_sim_theta(fact.at_m.data(), theta));
    REQUIRE(pal_falcon_sim_counts(fact.at_m.data(), counts));
    REQUIRE(pal_falcon_sim_jacobian(fact.at_m.data(), j));
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(theta[i] * kDegrees == Approx(fact.theta_deg[i]).margin(5.1e-5));
        CHECK(counts[i] == fact.counts[i]);
        double force = 0;  // J^T tau: the published torques must make 1, 2, 3 N
        for (std::size_t k = 0; k < 3; ++k) force += j[3 * k + i] * fact.torque_n_m[k];
        CHECK(force ==
              Approx(1.0 + static_cast<double>(i)).margin(6e-5));  // 3 x 20 rad/m x 5e-7 N m, and rounding
    }
}

TEST_CASE("the z column on the axis meets the published table") {
    struct Row {
        double z_m, theta_deg, jz, jxy;
    };
    const auto row = GENERATE(values<Row>({{0.075, -18.3, 24.8, 21.8},
                                           {0.090, -1.1, 17.0, 15.9},
                                           {0.110, 16.2, 13.785, 12.3},
                                           {0.135, 35.3, 13.4, 9.95},
                                           {0.170, 66.8, 21.1, 9.07},
                                           {0.180, 82.7, 41.6, 11.5}}));
    const double at[3] = {0, 0, row.z_m};
    double theta[3];
    double j[9];
    REQUIRE(pal_falcon_sim_theta(at, theta));
    REQUIRE(pal_falcon_sim_jacobian(at, j));
    CHECK(theta[0] * kDegrees == Approx(row.theta_deg).margin(0.05));
    CHECK(j[2] == Approx(row.jz).margin(row.z_m == 0.110 ? 5e-4 : 0.05));
    CHECK(std::hypot(j[0], j[1]) == Approx(row.jxy).margin(0.05));
}

TEST_CASE("the Jacobian is the derivative of the arm angles") {
    std::mt19937_64 random(7);
    int n = 0;
    for (int trial = 0; trial < 2000; ++trial) {
        const auto at = random_point(random);
        double j[9];
        if (!pal_falcon_sim_jacobian(at.data(), j)) continue;
        const double h = 1e-6;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            auto up = at;
            auto down = at;
            up[axis] += h;
            down[axis] -= h;
            double theta_up[3];
            double theta_down[3];
            if (!pal_falcon_sim_theta(up.data(), theta_up) ||
                !pal_falcon_sim_theta(down.data(), theta_down)) {
                continue;
            }
            for (std::size_t i = 0; i < 3; ++i) {
                const double slope = (theta_up[i] - theta_down[i]) / (2 * h);
                // Central difference: h^2 times a third derivative that grows like the cube of the slope near
                // the edge.
                const double scale = 1.0 + std::fabs(j[3 * i + axis]);
                CHECK(std::fabs(slope - j[3 * i + axis]) <= 1e-9 * scale * scale * scale);
                ++n;
            }
        }
    }
    CHECK(n > 5000);
}

TEST_CASE("motor force does the work of the arm torques along any small step") {
    const pal_falcon_sim_config config = pal_falcon_sim_config_default();
    std::mt19937_64 random(11);
    int n = 0;
    for (int trial = 0; trial < 500; ++trial) {
        const auto at = random_point(random);
        const int16_t words[3] = {static_cast<int16_t>(random() % 8191 - 4095),
                                  static_cast<int16_t>(random() % 8191 - 4095),
                                  static_cast<int16_t>(random() % 8191 - 4095)};
        double force[3];
        if (!pal_falcon_sim_motor_force(&config, at.data(), words, force)) continue;
        std::array<double, 3> low = at;
        std::array<double, 3> high = at;
        const double step[3] = {1e-7, -2e-7, 1.5e-7};
        for (std::size_t i = 0; i < 3; ++i) {
            low[i] -= step[i] / 2;
            high[i] += step[i] / 2;
        }
        double theta_low[3];
        double theta_high[3];
        if (!pal_falcon_sim_theta(low.data(), theta_low) || !pal_falcon_sim_theta(high.data(), theta_high))
            continue;
        double at_hand = 0;
        double at_arms = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            at_hand += force[i] * step[i];
            at_arms -= words[i] / config.units_per_n_m * (theta_high[i] - theta_low[i]);
        }
        CHECK(at_hand == Approx(at_arms).margin(1e-14));  // of some 1e-6 J
        ++n;
    }
    CHECK(n > 100);
}

TEST_CASE("positive words pull the grip in") {
    const pal_falcon_sim_config config = pal_falcon_sim_config_default();
    const double at[3] = {0, 0, 0.11};
    const int16_t words[3] = {900, 900, 900};
    double force[3];
    REQUIRE(pal_falcon_sim_motor_force(&config, at, words, force));
    CHECK(force[2] == Approx(-8.9).epsilon(0.01));  // 8.9 N need only about 900 units there
    CHECK(std::fabs(force[0]) < 1e-12);
    CHECK(std::fabs(force[1]) < 1e-12);
}

TEST_CASE("a warm start changes nothing but the time it takes") {
    std::mt19937_64 random(3);
    for (int trial = 0; trial < 500; ++trial) {
        const auto at = random_point(random);
        const double far[3] = {-0.43, 1.57, 99.0};
        double cold[3];
        double warm[3];
        const bool found = pal_falcon_sim_theta(at.data(), cold);
        REQUIRE(pal_falcon_solve_theta(at.data(), far, warm) == found);
        if (!found) continue;
        for (int i = 0; i < 3; ++i) CHECK(std::fabs(cold[i] - warm[i]) <= 1e-14);
    }
}

TEST_CASE("a position outside the workspace has no arm angles and leaves the output alone") {
    using Point = std::array<double, 3>;
    const auto at = GENERATE(values<Point>({{0, 0, 0.065},
                                            {0, 0, 0.19},
                                            {0.2, 0, 0.12},
                                            {0, -0.15, 0.12},
                                            {0, 0, -0.12},
                                            {0, 0, 0},
                                            {static_cast<double>(NAN), 0, 0.12},
                                            {0, static_cast<double>(INFINITY), 0.12}}));
    double theta[3] = {1, 2, 3};
    CHECK_FALSE(pal_falcon_sim_theta(at.data(), theta));
    CHECK(theta[0] == 1);
    CHECK(theta[2] == 3);
}

TEST_CASE("the workspace is about ten centimetres wide and high") {
    const double reach = GENERATE(as<double>{}, -0.045, 0.045);
    const double across[3] = {reach, 0, 0.12};
    const double upright[3] = {0, reach, 0.12};
    double theta[3];
    CHECK(pal_falcon_sim_theta(across, theta));
    CHECK(pal_falcon_sim_theta(upright, theta));
}
