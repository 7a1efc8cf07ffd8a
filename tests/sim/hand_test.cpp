#include "sim/hand/hand.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "sim/falcon/falcon_sim.h"

namespace {

using Point = std::array<double, 3>;
const Point kStart{0.001, 0.002, 0.12};

double distance(const double a[3], const Point& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

struct Case {
    std::vector<pal_hand_point> path{{0.0, {0, 0, 0.13}}, {0.1, {0.01, 0, 0.13}}, {0.3, {0.01, 0.02, 0.12}}};
    pal_hand_config config{};
    pal_hand hand{};

    explicit Case(uint32_t wait_ticks) {
        config.stiffness_n_per_m = 500;
        config.damping_n_s_per_m = 8;
        config.wait_ticks = wait_ticks;
        config.home_in_m[2] = 0.07;
        config.path = path.data();
        config.n_points = static_cast<uint32_t>(path.size());
        pal_hand_init(&hand, &config);
    }
    void run(int n_ticks, bool homed) {
        for (int i = 0; i < n_ticks; ++i) pal_hand_advance(&hand, homed, kStart.data());
    }
};

}  // namespace

TEST_CASE("before homing the hand goes smoothly from where the effector is to the reference and stays") {
    Case c(50);
    Point before = kStart;
    double speed_before = 0;
    for (int tick = 1; tick <= 600; ++tick) {
        c.run(1, false);
        const double step = distance(c.hand.target_m, before);
        // 3 x^2 - 2 x^3 over 0.4 s: at most 1.5 way/0.4 s and 6 way/0.16 s^2.
        const double way = distance(c.config.home_in_m, kStart);
        CHECK(step <= 1.5 * way / 400 * 1.001);
        CHECK(std::fabs(step - speed_before) <= 6 * way / 160000 * 1.001);
        speed_before = step;
        before = {c.hand.target_m[0], c.hand.target_m[1], c.hand.target_m[2]};
        if (tick >= 400) CHECK(distance(c.hand.target_m, {0, 0, 0.07}) == 0);
        CHECK(c.hand.path_tick == 0);
        CHECK(c.hand.homed_tick == 0);
    }
}

TEST_CASE("the path begins exactly wait_ticks after homing") {
    const uint32_t wait = GENERATE(as<uint32_t>{}, 0, 1, 2, 50, 700);
    Case c(wait);
    c.run(450, false);
    c.run(1, true);
    CHECK(c.hand.homed_tick == 451);
    const Point first{0, 0, 0.13};
    for (uint32_t since = 1; since < wait; ++since) {
        CHECK(c.hand.path_tick == 0);
        c.run(1, true);
    }
    if (wait > 0) {
        CHECK(distance(c.hand.target_m, first) < 1e-15);
        c.run(1, true);
    }
    for (uint32_t n = 1; n <= 5; ++n) {
        CHECK(c.hand.path_tick == n);
        CHECK(distance(c.hand.target_m, {0.0001 * n, 0, 0.13}) < 1e-12);
        c.run(1, true);
    }
}

TEST_CASE("a device that starts anew is homed again, and the path begins anew") {
    Case c(50);
    c.run(500, false);
    c.run(200, true);
    REQUIRE(c.hand.path_tick > 0);
    c.run(500, false);
    CHECK(distance(c.hand.target_m, {0, 0, 0.07}) == 0);
    CHECK(c.hand.path_tick == 0);
    c.run(50, true);
    CHECK(c.hand.path_tick == 0);
    c.run(1, true);
    CHECK(c.hand.path_tick == 1);
}

TEST_CASE("the way to the path's start has no jump") {
    Case c(100);
    c.run(250, false);  // homed while still moving in
    double worst = 0;
    Point before{c.hand.target_m[0], c.hand.target_m[1], c.hand.target_m[2]};
    for (int tick = 0; tick < 100; ++tick) {
        c.run(1, true);
        worst = std::fmax(worst, distance(c.hand.target_m, before));
        before = {c.hand.target_m[0], c.hand.target_m[1], c.hand.target_m[2]};
    }
    CHECK(worst < 1.5 * 0.06 / 100);
}

TEST_CASE("on the path the target and its velocity are those of straight lines, and the end is held") {
    Case c(0);
    c.run(50, true);  // path tick 50
    CHECK(distance(c.hand.target_m, {0.005, 0, 0.13}) < 1e-12);
    CHECK(distance(c.hand.target_velocity_m_per_s, {0.1, 0, 0}) < 1e-12);
    c.run(150, true);  // path tick 200: half of the second line
    CHECK(distance(c.hand.target_m, {0.01, 0.01, 0.125}) < 1e-12);
    CHECK(distance(c.hand.target_velocity_m_per_s, {0, 0.1, -0.05}) < 1e-12);
    c.run(500, true);
    CHECK(distance(c.hand.target_m, {0.01, 0.02, 0.12}) == 0);
    CHECK(distance(c.hand.target_velocity_m_per_s, {0, 0, 0}) == 0);
    CHECK(c.hand.path_tick == 700);
}

TEST_CASE("a path that begins late waits at its first point") {
    Case c(0);
    for (auto& point : c.path) point.t_s += 0.02;
    c.run(19, true);
    CHECK(distance(c.hand.target_m, {0, 0, 0.13}) == 0);
    c.run(11, true);
    CHECK(distance(c.hand.target_m, {0.001, 0, 0.13}) < 1e-12);
}

TEST_CASE("ten thousand points are followed each in its turn") {
    Case c(0);
    c.path.clear();
    for (int i = 0; i < 10000; ++i) {
        c.path.push_back({i * 0.0005, {0.01 * std::sin(0.002 * i), 0.01 * std::cos(0.002 * i), 0.12}});
    }
    c.config.path = c.path.data();
    c.config.n_points = 10000;
    pal_hand_init(&c.hand, &c.config);
    for (int tick = 1; tick <= 4999; ++tick) {
        c.run(1, true);
        REQUIRE(distance(c.hand.target_m,
                         {0.01 * std::sin(0.004 * tick), 0.01 * std::cos(0.004 * tick), 0.12}) < 1e-9);
    }
}

TEST_CASE("the hand pushes like a spring and a damper and carries the weight") {
    Case c(0);
    c.config.weight_n = 1.962;
    pal_hand_init(&c.hand, &c.config);
    c.run(50, true);
    const double at[3] = {0.004, 0, 0.131};
    const double velocity[3] = {0.02, 0.03, -0.01};
    double force[3];
    pal_hand_push(&c.hand, at, velocity, force);
    CHECK(force[0] == Approx(500 * 0.001 + 8 * 0.08));
    CHECK(force[1] == Approx(1.962 - 8 * 0.03));
    CHECK(force[2] == Approx(-500 * 0.001 + 8 * 0.01));
}

TEST_CASE("a light and a firm hand both home the device and then hold it at the path's start") {
    const bool firm = GENERATE(as<bool>{}, false, true);
    pal_falcon_sim_config device = pal_falcon_sim_config_default();
    pal_falcon_sim sim;
    REQUIRE(pal_falcon_sim_init(&sim, &device));
    Case c(800);
    c.config.mass_kg = firm ? 0.15 : 0.05;
    c.config.stiffness_n_per_m = firm ? 500 : 150;
    c.config.damping_n_s_per_m = firm ? 8 : 2;
    c.config.weight_n = device.mass_kg * device.gravity_m_per_s2;
    for (auto& point : c.path) point = {point.t_s, {0, 0, 0.13}};
    pal_hand_init(&c.hand, &c.config);
    sim.homing = 1;
    for (int tick = 0; tick < 2000; ++tick) {
        pal_hand_advance(&c.hand, sim.homed == 7, sim.position_m);
        pal_falcon_sim_advance(&sim, pal_hand_push, &c.hand, c.config.mass_kg);
    }
    CHECK(sim.homed == 7);
    CHECK(c.hand.homed_tick > 200);
    CHECK(c.hand.homed_tick < 600);
    // Dry friction leaves it c / K off at most.
    CHECK(distance(sim.position_m, {0, 0, 0.13}) <= 0.3 / c.config.stiffness_n_per_m);
}

TEST_CASE("where nobody holds the grip a helper homes the device, leads it to the path's start and lets go") {
    const double damping = GENERATE(as<double>{}, 0.0, 5.0);  // a hand may damp without a spring
    pal_falcon_sim_config device = pal_falcon_sim_config_default();
    pal_falcon_sim sim;
    REQUIRE(pal_falcon_sim_init(&sim, &device));
    Case c(800);
    c.config.stiffness_n_per_m = 0;
    c.config.damping_n_s_per_m = damping;
    pal_hand_init(&c.hand, &c.config);
    sim.homing = 1;
    const auto tick = [&] {
        pal_hand_advance(&c.hand, sim.homed == 7, sim.position_m);
        pal_falcon_sim_advance(&sim, pal_hand_push, &c.hand, c.config.mass_kg);
    };
    while (c.hand.tick < 600 && c.hand.homed_tick == 0) tick();
    REQUIRE(c.hand.homed_tick > 200);
    while (c.hand.tick < c.hand.homed_tick + 799) tick();
    REQUIRE(c.hand.path_tick == 0);
    // Its spring is 2000 N/m: the effector's 1.962 N and the dry friction of 0.3 N leave it that far off at
    // most.
    CHECK(distance(sim.position_m, {0, 0, 0.13}) <= (1.962 + 0.3) / 2000);
    tick();
    REQUIRE(c.hand.path_tick == 1);
    const double at[3] = {0.01, 0.02, 0.03};
    const double velocity[3] = {0.1, 0, 0};
    const double still[3] = {0, 0, 0};
    double force[3];
    pal_hand_push(&c.hand, at, still, force);
    for (std::size_t i = 0; i < 3; ++i) CHECK(force[i] == damping * c.hand.target_velocity_m_per_s[i]);
    pal_hand_push(&c.hand, at, velocity, force);
    CHECK(force[0] == Approx(damping * (c.hand.target_velocity_m_per_s[0] - 0.1)));
    for (int n = 0; n < 1000; ++n) tick();
    CHECK(sim.position_m[1] < -0.03);  // it fell to the end of its travel
}

TEST_CASE("without a path the helper lets go as soon as the device is homed") {
    Case c(800);
    c.config.stiffness_n_per_m = c.config.damping_n_s_per_m = 0;
    c.config.n_points = 0;
    pal_hand_init(&c.hand, &c.config);
    const double still[3] = {0, 0, 0};
    double force[3];
    c.run(450, false);
    pal_hand_push(&c.hand, kStart.data(), still, force);
    CHECK(force[2] < -50);
    c.run(1, true);
    pal_hand_push(&c.hand, kStart.data(), still, force);
    for (const double axis : force) CHECK(axis == 0);
}

TEST_CASE("a hand with a spring, however soft, has no helper") {
    Case c(0);
    c.config.stiffness_n_per_m = 1e-3;
    c.config.damping_n_s_per_m = 0;
    pal_hand_init(&c.hand, &c.config);
    c.run(400, false);
    const double still[3] = {0, 0, 0};
    double force[3];
    pal_hand_push(&c.hand, kStart.data(), still, force);
    CHECK(force[2] == Approx(1e-3 * (0.07 - kStart[2])));
}
