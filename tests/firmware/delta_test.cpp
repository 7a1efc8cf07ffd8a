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
    std::array<double, 3> theta_deg, theta2_deg, theta3_deg;
    std::array<std::int16_t, 3> counts;
    std::array<double, 3> torque_n_m;  // for F = (1, 2, 3) N
};

// Places, encoder counts and torques: docs/PROTOCOL.md 4. Computed independently, in double precision.
const Vector VECTORS[] = {
    {{0.0F, 0.0F, 0.08F},
     {-11.8000, -11.8000, -11.8000},
     {132.4163, 132.4163, 132.4163},
     {91.0677, 91.0677, 91.0677},
     {-1284, -1284, -1284},
     {-0.009027, 0.029892, 0.121700}},
    {{0.0F, 0.0F, 0.11F},
     {16.1880, 16.1880, 16.1880},
     {131.7302, 131.7302, 131.7302},
     {91.0677, 91.0677, 91.0677},
     {-516, -516, -516},
     {-0.015851, 0.044930, 0.188543}},
    {{0.0F, 0.0F, 0.125F},
     {27.7093, 27.7093, 27.7093},
     {129.0208, 129.0208, 129.0208},
     {91.0677, 91.0677, 91.0677},
     {-200, -200, -200},
     {-0.025674, 0.043789, 0.209069}},
    {{0.0F, 0.0F, 0.15F},
     {47.2433, 47.2433, 47.2433},
     {122.0393, 122.0393, 122.0393},
     {91.0677, 91.0677, 91.0677},
     {336, 336, 336},
     {-0.049491, 0.030133, 0.224269}},
    {{0.02F, 0.01F, 0.12F},
     {23.8701, 14.8169, 38.5990},
     {128.4324, 122.5666, 138.6061},
     {103.4359, 82.7555, 87.1138},
     {-305, -554, 99},
     {-0.013034, 0.077120, 0.182153}},
    {{-0.03F, 0.02F, 0.10F},
     {-7.7440, 37.6494, 10.5818},
     {118.1939, 149.4259, 131.0469},
     {77.6681, 84.6012, 111.3193},
     {-1173, 73, -670},
     {0.036689, -0.028869, 0.178149}},
    {{0.03F, -0.03F, 0.14F},
     {65.1884, 25.1500, 47.2175},
     {135.6464, 110.6445, 124.6493},
     {103.0377, 103.0377, 66.7164},
     {829, -270, 335},
     {-0.164374, 0.105944, 0.240243}},
    {{0.0F, 0.04F, 0.11F},
     {-4.9240, 30.6493, 42.2503},
     {112.0803, 137.7872, 144.6687},
     {96.8711, 69.0034, 107.1322},
     {-1096, -119, 199},
     {0.065850, 0.023125, 0.160859}},
};

double wide(float x) {
    return static_cast<double>(x);
}

std::array<double, 3> wide(const Vec& v) {
    return {wide(v[0]), wide(v[1]), wide(v[2])};
}

struct LegPlane {
    double u, v, w;
};

LegPlane leg_plane(std::size_t i, const std::array<double, 3>& at_m) {
    const double c = wide(NF1.cos_leg[i]), s = wide(NF1.sin_leg[i]);
    return {at_m[0] * c + at_m[1] * s - wide(NF1.base_u_m) + wide(NF1.platform_u_m),
            at_m[1] * c - at_m[0] * s - wide(NF1.base_v_m) + wide(NF1.platform_v_m), at_m[2]};
}

/// Arm angle by the closed form in double precision, from the same rounded geometry.
double theta_in_double(std::size_t i, const std::array<double, 3>& at_m) {
    const LegPlane leg = leg_plane(i, at_m);
    const double a = wide(NF1.arm_m);
    const double k =
        wide(NF1.offset_m) + wide(NF1.forearm_m) * std::sin(std::acos(leg.v / wide(NF1.forearm_m)));
    const double rho2 = leg.u * leg.u + leg.w * leg.w;
    return std::atan2(leg.w, leg.u) - std::acos((rho2 + a * a - k * k) / (2.0 * a * std::sqrt(rho2)));
}

double distance(const Vec& a, const Vec& b) {
    double sum = 0.0;
    for (std::size_t c = 0; c < 3; ++c) sum += (wide(a[c]) - wide(b[c])) * (wide(a[c]) - wide(b[c]));
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
            CHECK(std::fabs(wide(theta[i]) / DEGREE - v.theta_deg[i]) < 1.0e-4);
            REQUIRE(pal_delta_counts(&NF1, theta[i], &counts));
            CHECK(counts == v.counts[i]);
            CHECK(std::fabs(wide(torque[i]) - v.torque_n_m[i]) < 1.5e-6);
        }
    }
}

TEST_CASE("an encoder count is 0.0364347 degrees from an arm angle of 35 degrees") {
    CHECK(std::fabs(wide(pal_delta_theta_rad(&NF1, 0)) / DEGREE - 35.0) < 1.0e-5);
    CHECK(std::fabs(wide(pal_delta_theta_rad(&NF1, 1000)) / DEGREE - 71.4347) < 1.0e-4);
    CHECK(std::fabs(wide(pal_delta_theta_rad(&NF1, -1000)) / DEGREE + 1.4347) < 1.0e-4);
    std::int16_t counts = 0;
    CHECK_FALSE(pal_delta_counts(&NF1, 30.0F, &counts));
    CHECK_FALSE(pal_delta_counts(&NF1, NAN, &counts));
    for (int n = -1500; n <= 1500; ++n) {
        REQUIRE(pal_delta_counts(&NF1, pal_delta_theta_rad(&NF1, static_cast<std::int16_t>(n)), &counts));
        REQUIRE(counts == n);
    }
}

TEST_CASE("the encoder counts of the published vectors give their positions back within 50 um") {
    for (const Vector& v : VECTORS) {
        Vec theta, found;
        const Vec middle = {0.0F, 0.0F, 0.12F};
        for (std::size_t i = 0; i < 3; ++i) theta[i] = pal_delta_theta_rad(&NF1, v.counts[i]);
        REQUIRE(pal_delta_forward(&NF1, theta.data(), middle.data(), 12, found.data()));
        CHECK(distance(found, v.at_m) < 50.0e-6);  // half a count on each arm is up to 24 um along z
    }
}

TEST_CASE("the published forearm angles close each leg, and give the Jacobian by Stamper's formulas") {
    for (const Vector& v : VECTORS) {
        float jacobian[9];
        REQUIRE(pal_delta_jacobian(&NF1, v.at_m.data(), jacobian));
        for (std::size_t i = 0; i < 3; ++i) {
            const LegPlane leg = leg_plane(i, wide(v.at_m));
            const double t1 = v.theta_deg[i] * DEGREE, t2 = v.theta2_deg[i] * DEGREE,
                         t3 = v.theta3_deg[i] * DEGREE;
            const double a = wide(NF1.arm_m), b = wide(NF1.forearm_m);
            const double k = wide(NF1.offset_m) + b * std::sin(t3);
            // The page has four decimals: 0.9e-6 rad at arms of 0.06 and 0.125 m.
            CHECK(std::fabs(leg.u - a * std::cos(t1) - k * std::cos(t2)) < 0.2e-6);
            CHECK(std::fabs(leg.v - b * std::cos(t3)) < 0.2e-6);
            CHECK(std::fabs(leg.w - a * std::sin(t1) - k * std::sin(t2)) < 0.2e-6);
            const double c = wide(NF1.cos_leg[i]), s = wide(NF1.sin_leg[i]);
            const double d = a * std::sin(t3) * std::sin(t2 - t1);
            const std::array<double, 3> row = {(c * std::cos(t2) * std::sin(t3) - s * std::cos(t3)) / d,
                                               (s * std::cos(t2) * std::sin(t3) + c * std::cos(t3)) / d,
                                               std::sin(t2) * std::sin(t3) / d};
            // The same 0.9e-6 rad; a row changes by up to some 20 rad/m for each radian.
            for (std::size_t x = 0; x < 3; ++x) CHECK(std::fabs(wide(jacobian[3 * i + x]) - row[x]) < 3.0e-5);
        }
    }
}

TEST_CASE("torque and force do the same virtual work on any small displacement") {
    std::mt19937 random(7);
    std::normal_distribution<float> normal;
    constexpr double STEP_M = 1.0e-6;  // in double: the difference itself is good to 1e-8 of the force
    double worst = 0.0;
    int n_places = 0;
    for (int n = 0; n < 20000; ++n) {
        Vec at, theta, torque;
        if (!random_place(random, at, theta)) continue;
        const Vec force = {normal(random), normal(random), normal(random)};
        REQUIRE(pal_delta_torque(&NF1, at.data(), force.data(), torque.data()));
        const double size_n = std::hypot(wide(force[0]), wide(force[1]), wide(force[2]));
        ++n_places;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            auto lower = wide(at), upper = wide(at);
            lower[axis] -= STEP_M;
            upper[axis] += STEP_M;
            double work_j = 0.0;
            for (std::size_t i = 0; i < 3; ++i)
                work_j += wide(torque[i]) * (theta_in_double(i, upper) - theta_in_double(i, lower));
            worst = std::fmax(worst, std::fabs(work_j / (2.0 * STEP_M) - wide(force[axis])) / size_n);
        }
    }
    INFO("worst " << worst << " of the force, at " << n_places << " places");
    CHECK(n_places > 5000);
    // Some ten roundings of 6e-8 in the Jacobian, times its condition, which is up to 5: measured 3.4e-6.
    CHECK(worst < 5.0e-6);
}

TEST_CASE("on the axis arm angle, counts and Jacobian are those of the published table") {
    struct Row {
        float z_m;
        double theta_deg;
        int counts;
        double jz, jxy;  // rad/m, of each leg
    };
    const Row rows[] = {{0.065F, -37.0, -1975, 46.1, 33.5}, {0.075F, -18.3, -1463, 24.8, 21.8},
                        {0.090F, -1.1, -990, 17.0, 15.9},   {0.100F, 8.0, -741, 14.9, 13.8},
                        {0.110F, 16.2, -516, 13.8, 12.3},   {0.125F, 27.7, -200, 13.2, 10.7},
                        {0.135F, 35.3, 8, 13.4, 9.95},      {0.150F, 47.2, 336, 14.6, 9.17},
                        {0.170F, 66.8, 872, 21.1, 9.07},    {0.180F, 82.7, 1309, 41.6, 11.5}};
    for (const Row& row : rows) {
        CAPTURE(row.z_m);
        const Vec at = {0.0F, 0.0F, row.z_m};
        Vec theta;
        float jacobian[9];
        REQUIRE(pal_delta_inverse(&NF1, at.data(), theta.data()));
        REQUIRE(pal_delta_jacobian(&NF1, at.data(), jacobian));
        for (std::size_t i = 0; i < 3; ++i) {
            std::int16_t counts = 0;
            REQUIRE(pal_delta_counts(&NF1, theta[i], &counts));
            CHECK(counts == row.counts);
            CHECK(std::fabs(wide(theta[i]) / DEGREE - row.theta_deg) < 0.051);
            CHECK(std::fabs(wide(jacobian[3 * i + 2]) - row.jz) < 0.051);
            const double jxy = std::hypot(wide(jacobian[3 * i]), wide(jacobian[3 * i + 1]));
            CHECK(std::fabs(jxy - row.jxy) < (row.jxy < 10.0 ? 0.0051 : 0.051));  // the digits of the table
        }
    }
}

TEST_CASE("the z column of the Jacobian is sin theta2 sin theta3, 13.785 rad/m on the axis") {
    const Vec at = {0.0F, 0.0F, 0.11F};
    float jacobian[9];
    REQUIRE(pal_delta_jacobian(&NF1, at.data(), jacobian));
    for (int i = 0; i < 3; ++i) CHECK(std::fabs(wide(jacobian[3 * i + 2]) - 13.785) < 1.0e-3);
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
