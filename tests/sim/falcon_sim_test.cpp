#include "sim/falcon/falcon_sim.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <string>

#include "sim/falcon/kinematics.h"

namespace {

constexpr double kTickS = 1e-3;

pal_falcon_sim_config ideal() {  // no friction, no weight
    pal_falcon_sim_config config = pal_falcon_sim_config_default();
    config.gravity_m_per_s2 = 0;
    config.viscous_n_s_per_m = 0;
    config.coulomb_n = 0;
    return config;
}

pal_falcon_sim made(const pal_falcon_sim_config& config) {
    pal_falcon_sim sim;
    REQUIRE(pal_falcon_sim_init(&sim, &config));
    return sim;
}

std::string packet(const std::array<int, 3>& words, unsigned flags) {
    std::string out = "<";
    for (const int word : words) {
        for (unsigned n = 0; n < 4; ++n)
            out += static_cast<char>('A' + (static_cast<unsigned>(word) >> (4 * n) & 15U));
    }
    out += static_cast<char>('A' + flags);
    return out + "A>";
}

void send(pal_falcon_sim& sim, const std::array<int, 3>& words, unsigned flags = 0) {
    const std::string bytes = packet(words, flags);
    pal_falcon_sim_receive(&sim, reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
}

struct Reply {
    std::array<int, 3> counts;
    unsigned flags;
};

Reply ask(pal_falcon_sim& sim, unsigned flags = 0) {
    send(sim, {0, 0, 0}, flags);
    uint8_t bytes[16];
    REQUIRE(pal_falcon_sim_reply(&sim, bytes));
    Reply reply{{}, static_cast<unsigned>(bytes[13] - 'A')};
    for (std::size_t i = 0; i < 3; ++i) {
        unsigned word = 0;
        for (std::size_t n = 0; n < 4; ++n)
            word |= static_cast<unsigned>(bytes[1 + 4 * i + n] - 'A') << (4 * n);
        reply.counts[i] = word >= 0x8000U ? static_cast<int>(word) - 0x10000 : static_cast<int>(word);
    }
    return reply;
}

struct Spring {
    double stiffness_n_per_m;
    std::array<double, 3> rest_m;
};

void spring_push(const void* context, const double position_m[3], const double* /*velocity*/,
                 double force_n[3]) {
    const auto& spring = *static_cast<const Spring*>(context);
    for (std::size_t i = 0; i < 3; ++i)
        force_n[i] = spring.stiffness_n_per_m * (spring.rest_m[i] - position_m[i]);
}

void constant_push(const void* context, const double* /*position*/, const double* /*velocity*/,
                   double force_n[3]) {
    std::memcpy(force_n, context, 3 * sizeof(double));
}

double speed(const pal_falcon_sim& sim) {
    return std::hypot(sim.velocity_m_per_s[0], sim.velocity_m_per_s[1], sim.velocity_m_per_s[2]);
}

}  // namespace

TEST_CASE("without friction the effector falls as Galileo says") {
    pal_falcon_sim_config config = ideal();
    config.gravity_m_per_s2 = 9.81;
    pal_falcon_sim sim = made(config);
    for (int tick = 1; tick <= 60; ++tick) {
        pal_falcon_sim_advance(&sim, nullptr, nullptr, 0);
        const double t = tick * kTickS;
        // Semi-implicit Euler is ahead by half a sub-step of speed.
        CHECK(sim.position_m[1] == Approx(-0.5 * 9.81 * t * t).margin(9.81 * t * 13e-6));
        CHECK(sim.velocity_m_per_s[1] == Approx(-9.81 * t).epsilon(1e-12));
        CHECK(sim.position_m[0] == 0);
        CHECK(sim.position_m[2] == 0.12);
    }
}

TEST_CASE("viscous friction slows down exponentially") {
    pal_falcon_sim_config config = ideal();
    config.viscous_n_s_per_m = 2;
    pal_falcon_sim sim = made(config);
    sim.velocity_m_per_s[0] = 0.1;
    double before = 0.1;
    for (int tick = 1; tick <= 200; ++tick) {
        pal_falcon_sim_advance(&sim, nullptr, nullptr, 0);
        // Implicit Euler: relative error of (b/m)^2 dt t / 2 <= 100 * 25e-6 * 0.2 / 2.
        CHECK(sim.velocity_m_per_s[0] == Approx(0.1 * std::exp(-10 * tick * kTickS)).epsilon(3e-4));
        CHECK(speed(sim) < before);
        before = speed(sim);
    }
}

TEST_CASE("dry friction stops the effector after m v^2 / 2c and holds it") {
    pal_falcon_sim_config config = ideal();
    config.coulomb_n = 0.3;
    pal_falcon_sim sim = made(config);
    sim.velocity_m_per_s[0] = 0.12;
    sim.velocity_m_per_s[1] = 0.09;  // 0.15 m/s: stops after 100 ms
    for (int tick = 0; tick < 99; ++tick) pal_falcon_sim_advance(&sim, nullptr, nullptr, 0);
    CHECK(speed(sim) > 0);
    for (int tick = 0; tick < 2; ++tick) pal_falcon_sim_advance(&sim, nullptr, nullptr, 0);
    CHECK(speed(sim) == 0);
    const double way = std::hypot(sim.position_m[0], sim.position_m[1]);
    CHECK(way == Approx(0.2 * 0.15 * 0.15 / (2 * 0.3)).margin(0.15 * 25e-6));
    const double weak[3] = {0.17, 0.17, 0.17};  // 0.294 N
    const std::array<double, 3> stuck{sim.position_m[0], sim.position_m[1], sim.position_m[2]};
    for (int tick = 0; tick < 100; ++tick) pal_falcon_sim_advance(&sim, constant_push, weak, 0);
    for (std::size_t i = 0; i < 3; ++i) CHECK(sim.position_m[i] == stuck[i]);
    const double strong[3] = {0.18, 0.18, 0.18};  // 0.312 N
    pal_falcon_sim_advance(&sim, constant_push, strong, 0);
    CHECK(speed(sim) > 0);
}

TEST_CASE("a spring in the hand oscillates at its own frequency") {
    const double stiffness = GENERATE(as<double>{}, 150.0, 500.0);
    const double extra_kg = GENERATE(as<double>{}, 0.05, 0.15);
    const pal_falcon_sim_config config = ideal();
    const Spring spring{stiffness, {0, 0, 0.12}};
    pal_falcon_sim sim = made(config);
    const double omega = std::sqrt(stiffness / (config.mass_kg + extra_kg));
    const double amplitude = 0.01;
    sim.velocity_m_per_s[0] = omega * amplitude;
    double worst = 0;
    for (int tick = 1; tick <= 2000; ++tick) {
        pal_falcon_sim_advance(&sim, spring_push, &spring, extra_kg);
        worst = std::fmax(worst, std::fabs(sim.position_m[0] - amplitude * std::sin(omega * tick * kTickS)));
    }
    // First order in the sub-step: omega dt / 2 of the amplitude, and the phase (omega dt)^2 / 24 of each
    // radian.
    const double error = omega * 25e-6;
    CHECK(worst < amplitude * (error / 2 + error * error / 24 * omega * 2) * 1.1);
}

TEST_CASE("an encoder reads the nearest count") {
    pal_falcon_sim_config config = ideal();
    for (int step = 0; step < 300; ++step) {
        const double at[3] = {0.0001 * step - 0.015, 0.01, 0.11 + 0.0001 * step};
        int16_t counts[3];
        double theta[3];
        REQUIRE(pal_falcon_sim_counts(at, counts));
        REQUIRE(pal_falcon_sim_theta(at, theta));
        for (int i = 0; i < 3; ++i) {
            const double exact =
                (theta[i] * 180 / 3.14159265358979 - 35.0) / 0.0364347;  // the published figure, 6 digits
            CHECK(std::fabs(counts[i] - exact) <= 0.5 + 2e-3);
        }
    }
    std::memset(config.start_offset_counts, 0, sizeof config.start_offset_counts);
    pal_falcon_sim sim = made(config);
    int16_t counts[3];
    REQUIRE(pal_falcon_sim_counts(config.start_m, counts));
    CHECK(ask(sim).counts == std::array<int, 3>{counts[0], counts[1], counts[2]});
}

TEST_CASE("before homing the counters are off by what they started with, and wrap") {
    pal_falcon_sim_config config = ideal();
    config.start_offset_counts[0] = 1000;
    config.start_offset_counts[1] = -32768;
    config.start_offset_counts[2] = 0;
    pal_falcon_sim sim = made(config);
    int16_t counts[3];
    REQUIRE(pal_falcon_sim_counts(config.start_m, counts));
    CHECK(counts[1] < 0);
    const Reply reply = ask(sim);
    CHECK(reply.counts[0] == counts[0] + 1000);
    CHECK(reply.counts[1] == counts[1] + 32768);
    CHECK(reply.counts[2] == counts[2]);
    CHECK(reply.flags == 0);
}

TEST_CASE("an arm at its reference homes once, with a jump to the true reading, and only while asked to") {
    pal_falcon_sim_config config = ideal();
    config.coulomb_n = 0.3;
    config.viscous_n_s_per_m = 2;
    pal_falcon_sim sim = made(config);
    const Spring inwards{150, {0.01, 0.0, 0.070}};  // off the axis: the arms arrive one after the other
    for (int tick = 0; tick < 1000; ++tick) pal_falcon_sim_advance(&sim, spring_push, &inwards, 0.05);
    CHECK(ask(sim).flags == 0);
    sim = made(config);
    unsigned seen = 0;
    int n_jumps = 0;
    for (int tick = 0; tick < 1000; ++tick) {
        const Reply reply = ask(sim, 1);
        int16_t truth[3];
        REQUIRE(pal_falcon_sim_counts(sim.position_m, truth));
        for (std::size_t i = 0; i < 3; ++i) {
            const bool homed = (reply.flags >> (4 + i) & 1U) != 0;
            CHECK(reply.counts[i] == truth[i] + (homed ? 0 : config.start_offset_counts[i]));
            CHECK(homed == ((seen >> i & 1U) != 0 || sim.theta_rad[i] <= config.home_theta_rad));
            if (homed && (seen >> i & 1U) == 0) ++n_jumps;
            if (homed) seen |= 1U << i;
        }
        pal_falcon_sim_advance(&sim, spring_push, &inwards, 0.05);
    }
    CHECK(n_jumps == 3);
    CHECK(ask(sim, 1).flags == 0x70);
    const Spring outwards{150, {0, 0, 0.12}};
    for (int tick = 0; tick < 500; ++tick) pal_falcon_sim_advance(&sim, spring_push, &outwards, 0.05);
    CHECK(ask(sim, 0).flags == 0x70);
}

TEST_CASE("grip buttons are in the reply") {
    pal_falcon_sim sim = made(ideal());
    sim.buttons = 5;
    CHECK(ask(sim).flags == 5);
}

TEST_CASE("a motor word acts exactly delay_ticks after the tick in which it came") {
    pal_falcon_sim_config config = ideal();
    config.delay_ticks = GENERATE(as<uint32_t>{}, 0, 1, 2, 7);
    pal_falcon_sim sim = made(config);
    for (int tick = 0; tick < 40; ++tick) {
        const int word = tick == 10 ? 500 : (tick == 11 ? -300 : 0);
        send(sim, {word, 0, 0});
        pal_falcon_sim_advance(&sim, nullptr, nullptr, 0);
        const int since = tick - static_cast<int>(config.delay_ticks);
        CHECK(sim.motor_counts[0] == (since == 10 ? 500 : (since == 11 ? -300 : 0)));
        if (since < 10) CHECK(speed(sim) == 0);
        if (since == 10) CHECK(speed(sim) > 0);
    }
}

TEST_CASE("the watchdog cuts the motors after its time, and the encoders keep counting") {
    pal_falcon_sim_config config = ideal();
    config.watchdog_ticks = 20;
    config.viscous_n_s_per_m = 5;
    pal_falcon_sim sim = made(config);
    send(sim, {-300, -300, -300});
    for (int tick = 0; tick <= 30; ++tick) {
        const bool cut = tick >= 20;
        CHECK(pal_falcon_sim_watchdog(&sim) == cut);
        pal_falcon_sim_advance(&sim, nullptr, nullptr, 0);
        CHECK(sim.motor_counts[0] == (tick == 0 || cut ? 0 : -300));
        if (cut) CHECK(sim.force_n[2] == 0);
    }
    CHECK(sim.position_m[2] > 0.1205);
    const Reply reply = ask(sim);
    int16_t truth[3];
    REQUIRE(pal_falcon_sim_counts(sim.position_m, truth));
    CHECK(reply.counts[0] == truth[0] + config.start_offset_counts[0]);
    send(sim, {-300, -300, -300});
    pal_falcon_sim_advance(&sim, nullptr, nullptr, 0);
    pal_falcon_sim_advance(&sim, nullptr, nullptr, 0);
    CHECK(sim.motor_counts[0] == -300);
}

TEST_CASE("broken packets do not feed the watchdog") {
    pal_falcon_sim_config config = ideal();
    config.watchdog_ticks = 20;
    pal_falcon_sim sim = made(config);
    send(sim, {100, 100, 100});
    const std::string broken = "<AAAAAAAAAAAAAA<AAAAAAAAAAAAAAAA>";
    for (int tick = 0; tick < 25; ++tick) {
        pal_falcon_sim_receive(&sim, reinterpret_cast<const uint8_t*>(broken.data()), broken.size());
        pal_falcon_sim_advance(&sim, nullptr, nullptr, 0);
    }
    CHECK(sim.motor_counts[0] == 0);
}

TEST_CASE("the effector stays in the workspace however it is pushed") {
    const double newtons = GENERATE(as<double>{}, 5.0, 40.0, 4000.0);
    pal_falcon_sim_config config = ideal();
    config.viscous_n_s_per_m = 2;
    for (int direction = 0; direction < 24; ++direction) {
        const double height = -1 + 2 * (direction + 0.5) / 24;
        const double around = 2.399963 * direction;
        const double level = std::sqrt(1 - height * height);
        const double push[3] = {newtons * level * std::cos(around), newtons * level * std::sin(around),
                                newtons * height};
        pal_falcon_sim sim = made(config);
        for (int tick = 0; tick < 300; ++tick) {
            pal_falcon_sim_advance(&sim, constant_push, push, 0);
            double theta[3];
            REQUIRE(pal_falcon_sim_theta(sim.position_m, theta));
            for (const double angle : theta) {
                REQUIRE(angle >= PAL_FALCON_THETA_MIN_RAD);
                REQUIRE(angle <= PAL_FALCON_THETA_MAX_RAD);
            }
        }
        const Spring back{500, {0, 0, 0.12}};  // and it can leave the stop again
        for (int tick = 0; tick < 600; ++tick) pal_falcon_sim_advance(&sim, spring_push, &back, 0);
        CHECK(std::hypot(sim.position_m[0], sim.position_m[1], sim.position_m[2] - 0.12) < 0.01);
    }
}

TEST_CASE("a configuration that makes no sense is refused") {
    const int wrong = GENERATE(range(0, 9));
    pal_falcon_sim_config config = pal_falcon_sim_config_default();
    if (wrong == 0) config.mass_kg = 0;
    if (wrong == 1) config.mass_kg = static_cast<double>(NAN);
    if (wrong == 2) config.viscous_n_s_per_m = -1;
    if (wrong == 3) config.coulomb_n = static_cast<double>(INFINITY);
    if (wrong == 4) config.units_per_n_m = 0;
    if (wrong == 5) config.n_substeps = 0;
    if (wrong == 6) config.delay_ticks = PAL_FALCON_DELAY_MAX + 1;
    if (wrong == 7) config.start_m[2] = 0.3;
    if (wrong == 8) config.watchdog_ticks = 0;
    pal_falcon_sim sim;
    CHECK_FALSE(pal_falcon_sim_init(&sim, &config));
}
