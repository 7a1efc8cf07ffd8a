#include "firmware/core/delta.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace {

using Vec = std::array<float, 3>;
constexpr double DEGREE = 0.017453292519943295;
const pal_delta& NF1 = PAL_DELTA_NF1;

struct Vector {
    Vec at_m;
    std::array<double, 3> theta_deg;
    std::array<int, 3> counts;
    std::array<double, 3> torque_n_m;  // for F = (1, 2, 3) N
};

// docs/PROTOCOL.md 4: computed independently, in double precision.
const Vector VECTORS[] = {
    {{0.0F, 0.0F, 0.08F},
     {-11.8000, -11.8000, -11.8000},
     {-1284, -1284, -1284},
     {-0.009027, 0.029892, 0.121700}},
    {{0.0F, 0.0F, 0.11F}, {16.1880, 16.1880, 16.1880}, {-516, -516, -516}, {-0.015851, 0.044930, 0.188543}},
    {{0.0F, 0.0F, 0.125F}, {27.7093, 27.7093, 27.7093}, {-200, -200, -200}, {-0.025674, 0.043789, 0.209069}},
    {{0.0F, 0.0F, 0.15F}, {47.2433, 47.2433, 47.2433}, {336, 336, 336}, {-0.049491, 0.030133, 0.224269}},
    {{0.02F, 0.01F, 0.12F}, {23.8701, 14.8169, 38.5990}, {-305, -554, 99}, {-0.013034, 0.077120, 0.182153}},
    {{-0.03F, 0.02F, 0.10F}, {-7.7440, 37.6494, 10.5818}, {-1173, 73, -670}, {0.036689, -0.028869, 0.178149}},
    {{0.03F, -0.03F, 0.14F}, {65.1884, 25.1500, 47.2175}, {829, -270, 335}, {-0.164374, 0.105944, 0.240243}},
    {{0.0F, 0.04F, 0.11F}, {-4.9240, 30.6493, 42.2503}, {-1096, -119, 199}, {0.065850, 0.023125, 0.160859}},
};

double distance(const Vec& a, const Vec& b) {
    double sum = 0.0;
    for (std::size_t c = 0; c < 3; ++c) sum += (double{a[c]} - double{b[c]}) * (double{a[c]} - double{b[c]});
    return std::sqrt(sum);
}

/// A random place in the 102 mm cube that the arms reach with 5 degrees to spare, and its arm angles.
bool random_place(std::mt19937& random, Vec& at, Vec& theta) {
    std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
    at = {0.051F * unit(random), 0.051F * unit(random), 0.124F + 0.049F * unit(random)};
    if (!pal_delta_inverse(&NF1, at.data(), theta.data())) return false;
    for (const float t : theta) {
        if (t < NF1.theta_min_rad + 0.087F || t > NF1.theta_max_rad - 0.087F) return false;
    }
    return true;
}

}  // namespace

TEST_CASE("inverse kinematics, encoder counts and torques agree with the published vectors") {
    for (const Vector& v : VECTORS) {
        Vec theta;
        Vec torque;
        const Vec force = {1.0F, 2.0F, 3.0F};
        REQUIRE(pal_delta_inverse(&NF1, v.at_m.data(), theta.data()));
        REQUIRE(pal_delta_torque(&NF1, v.at_m.data(), force.data(), torque.data()));
        for (std::size_t i = 0; i < 3; ++i) {
            std::int16_t counts = 0;
            CHECK(std::fabs(double{theta[i]} / DEGREE - v.theta_deg[i]) < 1.0e-4);
            REQUIRE(pal_delta_counts(&NF1, theta[i], &counts));
            CHECK(counts == v.counts[i]);
            CHECK(std::fabs(double{torque[i]} - v.torque_n_m[i]) < 1.5e-6);
        }
    }
}

TEST_CASE("an encoder count is 0.0364347 degrees from an arm angle of 35 degrees") {
    CHECK(std::fabs(double{pal_delta_theta_rad(&NF1, 0)} / DEGREE - 35.0) < 1.0e-5);
    CHECK(std::fabs(double{pal_delta_theta_rad(&NF1, 1000)} / DEGREE - 71.4347) < 1.0e-4);
    CHECK(std::fabs(double{pal_delta_theta_rad(&NF1, -1000)} / DEGREE + 1.4347) < 1.0e-4);
    std::int16_t counts = 0;
    CHECK_FALSE(pal_delta_counts(&NF1, 30.0F, &counts));
    CHECK_FALSE(pal_delta_counts(&NF1, NAN, &counts));
    for (int n = -1500; n <= 1500; ++n) {
        REQUIRE(pal_delta_counts(&NF1, pal_delta_theta_rad(&NF1, static_cast<std::int16_t>(n)), &counts));
        REQUIRE(counts == n);
    }
}

TEST_CASE("torque and force do the same virtual work on any small displacement") {
    std::mt19937 random(7);
    std::normal_distribution<float> normal;
    for (int n = 0; n < 2000; ++n) {
        Vec at, theta, torque;
        if (!random_place(random, at, theta)) continue;
        const Vec force = {normal(random), normal(random), normal(random)};
        REQUIRE(pal_delta_torque(&NF1, at.data(), force.data(), torque.data()));
        for (std::size_t axis = 0; axis < 3; ++axis) {
            Vec lower = at, upper = at, theta_lower, theta_upper;
            lower[axis] -= 1.0e-3F;
            upper[axis] += 1.0e-3F;
            if (!pal_delta_inverse(&NF1, lower.data(), theta_lower.data())) continue;
            if (!pal_delta_inverse(&NF1, upper.data(), theta_upper.data())) continue;
            double work = 0.0;
            for (std::size_t i = 0; i < 3; ++i)
                work += double{torque[i]} * (double{theta_upper[i]} - double{theta_lower[i]});
            const double moved = double{upper[axis]} - double{lower[axis]};
            // Central differences over 2 mm: curvature of theta costs up to 1 % near the edge.
            CHECK(std::fabs(work / moved - double{force[axis]}) <
                  0.02 * (1.0 + std::fabs(double{force[axis]})));
        }
    }
}

TEST_CASE("the z column of the Jacobian is sin theta2 sin theta3, 13.785 rad/m on the axis") {
    const Vec at = {0.0F, 0.0F, 0.11F};
    float jacobian[9];
    REQUIRE(pal_delta_jacobian(&NF1, at.data(), jacobian));
    for (int i = 0; i < 3; ++i) CHECK(std::fabs(double{jacobian[3 * i + 2]} - 13.785) < 1.0e-3);
}

TEST_CASE("two full steps from 0.9 mm away find the position to half a micrometre") {
    std::mt19937 random(11);
    std::normal_distribution<float> normal;
    double worst_m = 0.0;
    int n_places = 0;
    for (int n = 0; n < 60000; ++n) {
        Vec at, theta, found;
        if (!random_place(random, at, theta)) continue;
        const Vec way = {normal(random), normal(random), normal(random)};
        const float length = std::sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
        Vec near = at;
        for (std::size_t c = 0; c < 3; ++c) near[c] += 0.9e-3F * way[c] / length;
        ++n_places;
        REQUIRE(pal_delta_forward(&NF1, theta.data(), near.data(), 2, found.data()));
        worst_m = std::fmax(worst_m, distance(found, at));
    }
    INFO("worst " << worst_m << " m of " << n_places);
    CHECK(n_places > 20000);
    CHECK(worst_m < 0.5e-6);
}

TEST_CASE("a cold start from the middle finds every reachable place within twelve steps") {
    std::mt19937 random(13);
    const Vec middle = {0.0F, 0.0F, 0.12F};
    double worst_m = 0.0;
    for (int n = 0; n < 60000; ++n) {
        Vec at, theta, found;
        if (!random_place(random, at, theta)) continue;
        REQUIRE(pal_delta_forward(&NF1, theta.data(), middle.data(), 12, found.data()));
        worst_m = std::fmax(worst_m, distance(found, at));
    }
    CHECK(worst_m < 0.5e-6);
}

TEST_CASE("without the second step the position would be off: the measure can fail") {
    const Vec at = {0.03F, -0.03F, 0.14F};
    Vec theta, found;
    REQUIRE(pal_delta_inverse(&NF1, at.data(), theta.data()));
    const Vec near = {0.0305F, -0.0295F, 0.1405F};
    CHECK_FALSE(pal_delta_forward(&NF1, theta.data(), near.data(), 1, found.data()));
}

TEST_CASE("outside the mechanism's reach there is no answer and nothing is written") {
    const Vec outside[] = {{0.0F, 0.0F, 0.30F},
                           {0.2F, 0.0F, 0.12F},
                           {0.0F, 0.0F, -0.3F},
                           {NAN, 0.0F, 0.12F},
                           {0.0F, INFINITY, 0.12F}};
    for (const Vec& at : outside) {
        Vec theta = {1.0F, 2.0F, 3.0F};
        Vec torque = {1.0F, 2.0F, 3.0F};
        const Vec force = {1.0F, 0.0F, 0.0F};
        CHECK_FALSE(pal_delta_inverse(&NF1, at.data(), theta.data()));
        CHECK_FALSE(pal_delta_torque(&NF1, at.data(), force.data(), torque.data()));
        CHECK(theta == Vec{1.0F, 2.0F, 3.0F});
        CHECK(torque == Vec{1.0F, 2.0F, 3.0F});
    }
}

TEST_CASE("arms beyond their travel, far from each other or not numbers give no position") {
    const Vec middle = {0.0F, 0.0F, 0.12F};
    const Vec bad[] = {{-0.5F, 0.4F, 0.4F},
                       {0.4F, 1.6F, 0.4F},
                       {NAN, 0.4F, 0.4F},
                       {0.4F, INFINITY, 0.4F},
                       {-0.43F, 1.5F, 1.5F}};
    for (const Vec& theta : bad) {
        Vec found = {1.0F, 2.0F, 3.0F};
        if (!pal_delta_forward(&NF1, theta.data(), middle.data(), 12, found.data())) {
            CHECK(found == Vec{1.0F, 2.0F, 3.0F});
            continue;
        }
        Vec back;  // an answer is an answer only when its arms are where they were measured
        REQUIRE(pal_delta_inverse(&NF1, found.data(), back.data()));
        for (std::size_t i = 0; i < 3; ++i) CHECK(std::fabs(back[i] - theta[i]) < 1.0e-5F);
    }
    Vec found;
    CHECK_FALSE(pal_delta_forward(&NF1, bad[0].data(), middle.data(), 12, found.data()));
    CHECK_FALSE(pal_delta_forward(&NF1, bad[1].data(), middle.data(), 12, found.data()));
    CHECK_FALSE(pal_delta_forward(&NF1, bad[2].data(), middle.data(), 12, found.data()));
}
