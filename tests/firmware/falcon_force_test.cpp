#include "firmware/falcon/force.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <vector>

#include "firmware/falcon/homing.h"
#include "tests/firmware/falcon_truth.hpp"

namespace {

using truth::Three;

pal_force_config no_ramp() {
    pal_force_config config = pal_force_config_default();
    config.ramp_us = 0;
    return config;
}

struct Result {
    std::uint32_t faults;
    Three words, applied_n;
};

Result words_at(const Three& at, const Three& force_n, float limit_n = 8.0F,
                const pal_force_config& config = no_ramp(), const pal_delta& delta = PAL_DELTA_NF1) {
    const std::array<float, 3> at_m{float(at[0]), float(at[1]), float(at[2])};
    const std::array<float, 3> force{float(force_n[0]), float(force_n[1]), float(force_n[2])};
    std::array<float, 3> applied{};
    pal_force state{};
    Result result{};
    result.faults =
        pal_force_words(&config, &delta, &state, at_m.data(), force.data(), limit_n, applied.data());
    for (std::size_t i = 0; i < 3; ++i) {
        result.words[i] = state.words[i];
        result.applied_n[i] = static_cast<double>(applied[i]);
    }
    return result;
}

double length(const Three& v) {
    return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

double degrees_between(const Three& a, const Three& b) {
    const double cosine = (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) / length(a) / length(b);
    return std::acos(std::min(1.0, cosine)) * 180.0 / truth::PI;
}

// The 26 directions to the neighbours of a cube.
std::vector<Three> directions() {
    std::vector<Three> all;
    for (int k = 0; k < 27; ++k) {
        const int row = k / 3 % 3;
        const int layer = k / 9;
        const Three d{k % 3 - 1.0, row - 1.0, layer - 1.0};
        if (k != 13) all.push_back({d[0] / length(d), d[1] / length(d), d[2] / length(d)});
    }
    return all;
}

const Three MIDDLE{0.0, 0.0, 0.11};

// Words sent every millisecond for as long as `demand` of motor 1 is wanted.
struct Heat {
    pal_force_config config = no_ramp();
    pal_force state{};

    double send(double demand) {
        pal_force_elapse(&config, &state, 1000);
        const std::array<std::int16_t, 3> words{static_cast<std::int16_t>(demand), 0, 0};
        (void)pal_force_counts(&config, &PAL_DELTA_NF1, &state, words.data());
        return state.words[0];
    }
};

}  // namespace

TEST_CASE("3 N act as 3 N by virtual work at every reachable pose, rounding of the words included") {
    int n_poses = 0;
    int n_reachable = 0;
    double worst_length = 0.0;
    double worst_degrees = 0.0;
    for (int x = -35; x <= 35; x += 5) {
        for (int y = -35; y <= 35; y += 5) {
            for (int z = 75; z <= 175; z += 5) {
                const Three at{x * 1e-3, y * 1e-3, z * 1e-3};
                n_poses += 1;
                if (!truth::force_n(at, {0.0, 0.0, 0.0})) continue;
                n_reachable += 1;
                for (const Three& d : directions()) {
                    const Three wanted{3.0 * d[0], 3.0 * d[1], 3.0 * d[2]};
                    const Result r = words_at(at, wanted);
                    REQUIRE(r.faults == 0);
                    const Three acts = *truth::force_n(at, r.words);
                    worst_length = std::max(worst_length, std::abs(length(acts) / 3.0 - 1.0));
                    worst_degrees = std::max(worst_degrees, degrees_between(acts, wanted));
                }
            }
        }
    }
    CHECK(n_poses == 4725);
    CHECK(n_reachable == 3973);   // 84 %: where each arm is within -25 to 90 degrees, all of them served
    CHECK(worst_length < 0.005);  // 0.29 % when written
    CHECK(worst_degrees < 0.5);   // 0.18 degrees when written
}

TEST_CASE("a wrong sign or gain would not pass for the force") {
    pal_delta wrong = PAL_DELTA_NF1;
    wrong.units_per_n_m = 4200.0F * 1.01F;
    const Result r = words_at(MIDDLE, {1.0, 2.0, 2.0}, 8.0F, no_ramp(), wrong);
    CHECK(std::abs(length(*truth::force_n(MIDDLE, r.words)) / 3.0 - 1.0) > 0.005);
}

TEST_CASE("a force beyond the limit keeps its direction and has the limit's length") {
    const float limit_n = GENERATE(as<float>{}, 0.5F, 3.0F, 8.0F, 100.0F);
    const double expected_n = std::min(8.0, static_cast<double>(limit_n));
    for (const Three& d : directions()) {
        const Result r = words_at(MIDDLE, {50.0 * d[0], 50.0 * d[1], 50.0 * d[2]}, limit_n);
        CHECK(r.faults == PAL_FORCE_CLAMPED);
        CHECK(length(r.applied_n) == Approx(expected_n).epsilon(1e-5));
        CHECK(degrees_between(r.applied_n, d) < 0.05);
    }
    CHECK(words_at(MIDDLE, {1.0, 0.0, 0.0}, 0.0F).words == Three{0.0, 0.0, 0.0});
    CHECK(words_at(MIDDLE, {1.0, 0.0, 0.0}, -5.0F).words == Three{0.0, 0.0, 0.0});
}

TEST_CASE("a word beyond the motor's maximum scales all three, so the direction stays") {
    pal_force_config config = no_ramp();
    config.rms_margin = 100.0F;  // cold motors are never limited
    pal_delta weak = PAL_DELTA_NF1;
    weak.motor_max = 300;
    for (const Three& d : directions()) {
        const Result r = words_at(MIDDLE, {8.0 * d[0], 8.0 * d[1], 8.0 * d[2]}, 8.0F, config, weak);
        REQUIRE((r.faults & PAL_FORCE_SATURATED) != 0);
        const double largest = std::max({std::abs(r.words[0]), std::abs(r.words[1]), std::abs(r.words[2])});
        CHECK(largest == 300.0);
        const Three acts = *truth::force_n(MIDDLE, r.words);
        CHECK(degrees_between(acts, d) < 0.5);
        CHECK(length(acts) == Approx(length(r.applied_n)).epsilon(0.005));
    }
}

TEST_CASE("no number, however wild, gets out beyond the motor's maximum or the limit") {
    std::mt19937 random(5);
    const pal_force_config config = no_ramp();
    for (int n = 0; n < 200000; ++n) {
        std::array<float, 7> in{};
        for (float& x : in) {
            const std::uint32_t bits = static_cast<std::uint32_t>(random());
            std::memcpy(&x, &bits, sizeof x);  // any float there is
            if (n % 2 == 0) x = static_cast<float>(random() % 2001) * 0.01F - 10.0F;
        }
        if (n % 3 != 0) std::copy_n(std::array<float, 3>{0.01F, -0.02F, 0.12F}.begin(), 3, in.begin());
        pal_force state{};
        std::array<float, 3> applied{};
        const std::uint32_t faults =
            pal_force_words(&config, &PAL_DELTA_NF1, &state, in.data(), in.data() + 3, in[6], applied.data());
        for (const std::int16_t word : state.words) REQUIRE(std::abs(word) <= 4095);
        const double applied_n = length({static_cast<double>(applied[0]), static_cast<double>(applied[1]),
                                         static_cast<double>(applied[2])});
        REQUIRE(applied_n <= 8.0001);
        const bool refused = (faults & (PAL_FORCE_NOT_FINITE | PAL_FORCE_WORKSPACE)) != 0;
        if (refused) REQUIRE((state.words[0] == 0 && state.words[1] == 0 && state.words[2] == 0));
    }
}

TEST_CASE("a motor warms and cools as a first-order system, and its word follows the closed form") {
    constexpr double L = 2000.0, TAU_S = 10.0, G = 4.0, D = 3500.0;
    Heat heat;
    // q = D^2 (1 - e^(-t/tau)) until L^2 + G (L^2 - q) = D^2 ...
    const double q_limit = L * L - (D * D - L * L) / G;
    const double t_limit_s = -TAU_S * std::log(1.0 - q_limit / (D * D));
    for (int n = 0; n < 60000; ++n) {
        const double word = heat.send(D);
        const double t_s = (n + 0.5) * 1e-3;
        // ... then L^2 - q shrinks as e^(-(1 + G) t / tau).
        const double left = (L * L - q_limit) * std::exp(-(1.0 + G) * (t_s - t_limit_s) / TAU_S);
        const double expected = t_s < t_limit_s ? D : std::sqrt(L * L + G * left);
        REQUIRE(word == Approx(expected).epsilon(0.002));
    }
    CHECK(heat.send(D) == Approx(L).margin(1.5));  // for ever
    CHECK(t_limit_s == Approx(1.72).margin(0.01));
    const double q = static_cast<double>(heat.state.mean_square[0]);
    (void)heat.send(0.0);
    for (int n = 0; n < 10000; ++n) (void)heat.send(0.0);
    CHECK(static_cast<double>(heat.state.mean_square[0]) == Approx(q * std::exp(-1.0)).epsilon(0.001));
}

TEST_CASE("whatever is asked, the mean square of a motor never passes the limit") {
    Heat heat;
    std::mt19937 random(11);
    double demand = 0.0;
    for (int n = 0; n < 300000; ++n) {
        if (random() % 300 == 0) demand = static_cast<double>(random() % 8191) - 4095.0;
        (void)heat.send(demand);
        REQUIRE(heat.state.mean_square[0] <= 2000.0F * 2000.0F * 1.001F);
    }
}

TEST_CASE("one warm motor scales the words of all three") {
    Heat heat;
    for (int n = 0; n < 60000; ++n) (void)heat.send(4000.0);
    pal_force_elapse(&heat.config, &heat.state, 1000);
    const std::array<std::int16_t, 3> words{4000, -1000, 500};
    CHECK(pal_force_counts(&heat.config, &PAL_DELTA_NF1, &heat.state, words.data()) == PAL_FORCE_WARM);
    CHECK(heat.state.words[0] == Approx(2000).margin(2));
    CHECK(heat.state.words[1] == Approx(-500).margin(1));
    CHECK(heat.state.words[2] == Approx(250).margin(1));
}

TEST_CASE("the start ramp is linear in time, whatever the steps, and starts again on demand") {
    const std::uint32_t dt_us = GENERATE(as<std::uint32_t>{}, 200, 1000, 7000);
    const pal_force_config config = pal_force_config_default();
    pal_force state{};
    const std::array<std::int16_t, 3> words{1000, -1000, 0};
    for (int round = 0; round < 2; ++round) {
        pal_force_restart(&state);
        for (std::uint32_t t_us = 0; t_us < 700000; t_us += dt_us) {
            pal_force_elapse(&config, &state, dt_us);
            (void)pal_force_counts(&config, &PAL_DELTA_NF1, &state, words.data());
            const double share = std::min(1.0, t_us / 500000.0);
            REQUIRE(std::abs(state.words[0] - 1000.0 * share) <= 0.51);
            REQUIRE(state.words[1] == -state.words[0]);
        }
    }
}

TEST_CASE("a button counts once it has been held, and a bounce does not") {
    constexpr std::uint32_t HOLD_US = 10000;
    pal_grip grip{};
    for (int n = 0; n < 100; ++n) {  // bounces of 9 ms
        pal_grip_step(&grip, n % 10 < 9 ? 0x5 : 0x0, 1000, HOLD_US);
        REQUIRE(grip.buttons == 0);
    }
    pal_grip_step(&grip, 0, 1000, HOLD_US);
    for (int n = 0; n <= 12; ++n) {  // first seen at n = 0: held for n ms
        pal_grip_step(&grip, 0x8, 1000, HOLD_US);
        REQUIRE(grip.buttons == (n >= 10 ? 0x8 : 0));
    }
    for (int n = 0; n <= 12; ++n) {  // one released, another pressed 3 ms later
        pal_grip_step(&grip, n < 3 ? 0x0 : 0x2, 1000, HOLD_US);
        REQUIRE(grip.buttons == (n >= 10 ? 0x0 : 0x8));
    }
    pal_grip_step(&grip, 0x2, 1000, HOLD_US);
    CHECK(grip.buttons == 0x2);
    pal_grip_step(&grip, 0x4, 0, 0);  // no debounce at all
    CHECK(grip.buttons == 0x4);
    pal_grip_step(&grip, 0x0, 0xFFFFFFFFU, HOLD_US);  // seen for the first time after a long gap
    CHECK(grip.buttons == 0x4);
    pal_grip_step(&grip, 0x0, 0xFFFFFFFFU, HOLD_US);
    CHECK(grip.buttons == 0x0);
}
