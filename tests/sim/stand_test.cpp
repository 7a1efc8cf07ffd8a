#include "sim/stand/stand.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "common/table_ring.h"
#include "firmware/core/delta.h"

namespace {

constexpr double kStiffness = 800;
constexpr double kHalfCountM = 25e-6;  // half a count is up to 24 um along z (docs/PROTOCOL.md 4)
// Half a unit on each arm through |J| of about 13.8 rad/m along z.
constexpr double kHalfUnitN = 3 * 0.5 / 4200 * 14;

/// A level sheet of one stiffness at height `level_m` of the workspace, facing the user.
void fill_flat(pal_table& table, uint64_t id, float level_m, double stiffness_n_per_m) {
    std::memset(&table, 0, sizeof table);
    table.id = id;
    table.n_nodes = 17;
    table.spacing_m = 0.006F;
    table.valid_radius_m = 0.047F;
    table.depth_scale_m = 0.001F;
    table.p0_m[2] = level_m;
    for (std::size_t i = 0; i < 3; ++i) table.axes[4 * i] = 1.0F;
    const std::size_t plane = 19 * 19;
    std::fill(table.coef + plane, table.coef + 2 * plane, static_cast<float>(stiffness_n_per_m));
    pal_table_seal(&table);
}

struct Bench {
    std::unique_ptr<pal_link> link = std::make_unique<pal_link>();
    std::vector<pal_hand_point> path;
    pal_stand_config config{};
    pal_stand* stand = nullptr;
    uint64_t next_id = 1;

    explicit Bench(std::vector<pal_hand_point> hand_path) : path(std::move(hand_path)) {
        pal_link_init(link.get(), 1);
        link->host.enable = 1;
        config.falcon = pal_falcon_sim_config_default();
        config.force_max_n = 8;
        config.ramp_ticks = 200;
        config.hand.mass_kg = 0.15;
        config.hand.stiffness_n_per_m = 500;
        config.hand.damping_n_s_per_m = 8;
        config.hand.weight_n = config.falcon.mass_kg * config.falcon.gravity_m_per_s2;
        config.hand.home_in_m[2] = 0.070;
        config.hand.wait_ticks = 500;
        config.hand.path = path.data();
        config.hand.n_points = static_cast<uint32_t>(path.size());
        stand = pal_stand_new(&config, link.get());
        REQUIRE(stand != nullptr);
    }
    Bench(const Bench&) = delete;
    Bench& operator=(const Bench&) = delete;
    ~Bench() { pal_stand_free(stand); }

    void publish(float level_m = 0.0F, double stiffness_n_per_m = kStiffness) {
        fill_flat(*pal_table_ring_back(&link->tables), next_id++, level_m, stiffness_n_per_m);
        pal_table_ring_publish(&link->tables);
    }
    /// The same stand from its start, with `config` as it is now.
    void restart() {
        pal_stand_free(stand);
        stand = pal_stand_new(&config, link.get());
        REQUIRE(stand != nullptr);
    }
    /// Publishes the same sheet every 50 ticks, as a host does.
    std::vector<pal_tick> run(int n_ticks) {
        std::vector<pal_tick> ticks(static_cast<std::size_t>(n_ticks));
        for (std::size_t i = 0; i < ticks.size(); ++i) {
            if (i % 50 == 0) publish();
            pal_stand_tick(stand, &ticks[i]);
        }
        return ticks;
    }
};

/// Device frame: the workspace's origin is at z 0.12.
std::vector<pal_hand_point> press_to(double depth_m) {
    return {{0.0, {0, 0, 0.13}}, {1.0, {0, 0, 0.12 - depth_m}}, {3.0, {0, 0, 0.12 - depth_m}}};
}

}  // namespace

TEST_CASE("a hand that presses a flat sheet feels stiffness times depth") {
    const double target_m = GENERATE(as<double>{}, 0.005, 0.012, 0.020);
    Bench bench(press_to(target_m));
    const auto ticks = bench.run(4000);
    const pal_tick& last = ticks.back();
    REQUIRE(last.state == PAL_STATE_ENABLED);
    REQUIRE(last.truth_valid == 1);
    const double depth_m = -static_cast<double>(last.truth_position_m[2]);
    CHECK(last.truth_force_n[2] ==
          Approx(kStiffness * depth_m).margin(kStiffness * kHalfCountM + kHalfUnitN));
    CHECK(last.depth_m == Approx(depth_m).margin(kHalfCountM));
    CHECK(last.k_n_per_m == Approx(kStiffness));
    CHECK(std::fabs(static_cast<double>(last.truth_force_n[0])) < kStiffness * kHalfCountM);
    // The hand's spring and the sheet in series, up to the dry friction.
    const double series_n = target_m / (1.0 / 500 + 1.0 / kStiffness);
    CHECK(last.truth_force_n[2] == Approx(series_n).margin(0.3 + kStiffness * kHalfCountM));
    CHECK(last.hand_target_m[2] == Approx(-target_m).margin(1e-8));
}

TEST_CASE("two runs give the same bytes") {
    std::array<std::vector<pal_tick>, 2> runs;
    for (auto& run : runs) {
        Bench bench(press_to(0.01));
        run = bench.run(2500);
    }
    REQUIRE(runs[0].size() == runs[1].size());
    CHECK(std::memcmp(runs[0].data(), runs[1].data(), runs[0].size() * sizeof(pal_tick)) == 0);
    CHECK(runs[0].back().truth_force_n[2] > 1.0F);
}

TEST_CASE("one encoder count at the start shows in the records of a run") {
    std::array<std::vector<pal_tick>, 2> runs;
    for (std::size_t i = 0; i < 2; ++i) {
        Bench bench(press_to(0.01));
        bench.config.falcon.start_offset_counts[0] =
            static_cast<int16_t>(bench.config.falcon.start_offset_counts[0] + static_cast<int>(i));
        bench.restart();
        runs[i] = bench.run(10);
    }
    CHECK(std::memcmp(runs[0].data(), runs[1].data(), runs[0].size() * sizeof(pal_tick)) != 0);
}

TEST_CASE("the ring of records holds what each tick returned, in virtual time") {
    Bench bench(press_to(0.01));
    const auto ticks = bench.run(700);
    pal_state_reader reader{};
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        pal_tick record;
        REQUIRE(pal_state_ring_read(&bench.link->ticks, &reader, &record));
        REQUIRE(std::memcmp(&record, &ticks[i], sizeof record) == 0);
        CHECK(record.tick == i);
        CHECK(record.t_ns == 1000000U * i);
    }
}

TEST_CASE("every tick from the first has a sample, and homing and path follow each other") {
    Bench bench(press_to(0.01));
    const auto ticks = bench.run(2500);
    uint32_t homed_at = 0;
    for (const pal_tick& tick : ticks) {
        CHECK((tick.faults & PAL_FAULT_LATE) == 0);
        if (homed_at == 0 && tick.homed == 7) homed_at = tick.tick;
        if (homed_at == 0) {
            CHECK(tick.state == PAL_STATE_HOMING);
            CHECK(tick.motor_counts[0] == 0);
        }
        // The hand sees the device homed in the tick whose reply says so to the next one.
        const uint32_t begins = homed_at + 500;
        const bool on_path = homed_at != 0 && tick.tick >= begins;
        CHECK(tick.path_tick == (on_path ? tick.tick - begins + 1 : 0));
    }
    CHECK(homed_at > 100);
    CHECK(homed_at < 500);
}

TEST_CASE("a device that nobody holds is homed and then left alone on its path") {
    Bench bench(press_to(0.01));
    bench.config.hand.mass_kg = bench.config.hand.stiffness_n_per_m = bench.config.hand.damping_n_s_per_m = 0;
    bench.config.hand.weight_n = 0;
    bench.restart();
    const auto ticks = bench.run(2500);
    const auto begins =
        std::find_if(ticks.begin(), ticks.end(), [](const pal_tick& tick) { return tick.path_tick == 1; });
    REQUIRE(begins != ticks.end());
    CHECK(begins->homed == 7);
    CHECK(begins->truth_position_m[2] == Approx(0.01).margin(1e-3));
    // Free fall against the friction of the device alone, which is 2 N s/m and 0.3 N, 50 ticks long.
    const pal_tick& falling = *(begins + 50);
    CHECK(falling.truth_position_m[1] - begins->truth_position_m[1] ==
          Approx(-0.5 * (9.81 - 0.3 / 0.2) * 0.05 * 0.05).epsilon(0.25));
    CHECK(ticks.back().truth_position_m[1] < -0.03F);
}

TEST_CASE("a table that was published before a tick is used in it, and a bad one is refused") {
    Bench bench(press_to(0.01));
    const auto ticks = bench.run(1000);
    CHECK(ticks[0].table_id == 1);
    CHECK(ticks[949].table_id == 19);
    CHECK(ticks[950].table_id == 20);
    pal_table* bad = pal_table_ring_back(&bench.link->tables);
    fill_flat(*bad, 21, 0.0F, kStiffness);
    bad->coef[500] += 1.0F;  // after sealing
    pal_table_ring_publish(&bench.link->tables);
    pal_tick record;
    pal_stand_tick(bench.stand, &record);
    CHECK(record.table_id == 20);
    CHECK((record.faults & PAL_FAULT_TABLE_BAD) != 0);
    CHECK(bench.link->loop.n_bad_tables == 1);
    bench.next_id = 22;
    bench.publish();
    pal_stand_tick(bench.stand, &record);
    CHECK(record.table_id == 22);
}

TEST_CASE("the host's words stop and pause the forces in the next tick") {
    const bool estop = GENERATE(as<bool>{}, true, false);
    Bench bench(press_to(0.015));
    const auto ticks = bench.run(2400);
    REQUIRE(ticks.back().truth_force_n[2] > 2.0F);
    if (estop) {
        pal_link_store(&bench.link->host.estop, 1);
    } else {
        pal_link_store(&bench.link->host.enable, 0);
    }
    pal_tick record;
    pal_stand_tick(bench.stand, &record);
    for (const int16_t word : record.motor_counts) CHECK(word == 0);
    CHECK(record.state == (estop ? PAL_STATE_FAULT : PAL_STATE_PAUSED));
}

TEST_CASE("sensed and true position differ by rounding, and by one tick of motion") {
    Bench bench(press_to(0.01));
    const auto ticks = bench.run(2500);
    int n = 0;
    for (std::size_t i = 1; i < ticks.size(); ++i) {
        if (ticks[i].state != PAL_STATE_ENABLED) continue;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            // The sample of a tick was taken at the end of the tick before.
            const float off_m = ticks[i].position_m[axis] - ticks[i - 1].truth_position_m[axis];
            CHECK(std::fabs(static_cast<double>(off_m)) < 2 * kHalfCountM);
        }
        ++n;
    }
    CHECK(n > 1000);
}

TEST_CASE("the true force is what the words of the same tick do where the effector ended") {
    Bench bench(press_to(0.015));
    int n_changed = 0;
    pal_tick before{};
    for (const pal_tick& tick : bench.run(2500)) {
        double at[3];
        double force[3];
        for (std::size_t i = 0; i < 3; ++i)
            at[i] = static_cast<double>(tick.truth_position_m[i]) + (i == 2 ? 0.12 : 0.0);
        REQUIRE(pal_falcon_sim_motor_force(&bench.config.falcon, at, tick.motor_counts, force));
        // The record's position is rounded to float: some 1e-9 m.
        CHECK(static_cast<double>(tick.truth_force_n[2]) == Approx(force[2]).margin(1e-5));
        if (tick.motor_counts[0] != before.motor_counts[0]) ++n_changed;
        before = tick;
    }
    CHECK(n_changed > 50);
}

TEST_CASE("the firmware's kinematics invert the simulator's") {
    int n = 0;
    for (int step = 0; step < 4000; ++step) {
        const double at[3] = {0.04 * std::sin(0.37 * step), 0.04 * std::sin(0.53 * step + 1),
                              0.125 + 0.035 * std::sin(0.71 * step + 2)};
        double theta[3];
        if (!pal_falcon_sim_theta(at, theta)) continue;
        const float angles[3] = {static_cast<float>(theta[0]), static_cast<float>(theta[1]),
                                 static_cast<float>(theta[2])};
        const float near[3] = {static_cast<float>(at[0] + 3e-4), static_cast<float>(at[1] - 3e-4),
                               static_cast<float>(at[2] + 3e-4)};
        float found[3];
        REQUIRE(pal_delta_forward(&PAL_DELTA_NF1, angles, near, 4, found));
        for (std::size_t i = 0; i < 3; ++i) CHECK(std::fabs(static_cast<double>(found[i]) - at[i]) < 1e-6);
        ++n;
    }
    CHECK(n > 2000);
}

TEST_CASE("the static path makes stiffness times depth anywhere in the workspace") {
    using Place = std::array<double, 2>;
    const auto place =
        GENERATE(values<Place>({{0, 0}, {0.02, 0.01}, {-0.03, 0.0}, {0.01, -0.03}, {-0.02, 0.02}}));
    pal_stand_config config{};
    config.falcon = pal_falcon_sim_config_default();
    config.force_max_n = 8;
    auto table = std::make_unique<pal_table>();
    fill_flat(*table, 1, 0.0F, kStiffness);
    for (int step = 1; step <= 50; ++step) {
        const double depth_m = 1e-4 * step;
        const double at[3] = {place[0], place[1], -depth_m};
        double force[3];
        REQUIRE(pal_stand_static_force(&config, table.get(), at, force));
        CHECK(force[2] == Approx(kStiffness * depth_m).margin(2 * kStiffness * kHalfCountM + 2 * kHalfUnitN));
        CHECK(std::hypot(force[0], force[1]) < 0.05);
    }
}

TEST_CASE("the static path clamps the vector, is silent outside contact and knows the workspace's end") {
    pal_stand_config config{};
    config.falcon = pal_falcon_sim_config_default();
    config.force_max_n = 2;
    auto table = std::make_unique<pal_table>();
    fill_flat(*table, 1, 0.0F, kStiffness);
    double force[3];
    const double deep[3] = {0.01, 0.01, -0.02};
    REQUIRE(pal_stand_static_force(&config, table.get(), deep, force));
    CHECK(std::hypot(force[0], force[1], force[2]) == Approx(2).margin(0.02));
    const double above[3] = {0, 0, 0.001};
    REQUIRE(pal_stand_static_force(&config, table.get(), above, force));
    CHECK(force[2] == 0);
    const double outside[3] = {0, 0, 0.08};
    CHECK_FALSE(pal_stand_static_force(&config, table.get(), outside, force));
}

TEST_CASE("the look-up of the stand is that of the table") {
    auto table = std::make_unique<pal_table>();
    fill_flat(*table, 1, 0.002F, kStiffness);
    const float at[3] = {0.0F, 0.0F, 0.0F};
    float force[3];
    pal_stand_table_force(table.get(), at, force);
    CHECK(static_cast<double>(force[2]) == Approx(1.6).epsilon(1e-5));
}

TEST_CASE("a stand whose device makes no sense is not built") {
    auto link = std::make_unique<pal_link>();
    pal_link_init(link.get(), 1);
    pal_stand_config config{};
    CHECK(pal_stand_new(&config, link.get()) == nullptr);
}
