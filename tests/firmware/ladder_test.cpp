#include <catch2/catch.hpp>

#include "tests/firmware/loop_bench.hpp"

namespace {

/// In contact: 2 mm below a flat skin of 800 N/m, settled.
struct Pressing : LoopBench {
    std::unique_ptr<pal_table> table = tables::make();
    Pressing() {
        given.now = table.get();
        move(0.0, 0.0, -2.0e-3);
        step();
    }
};

}  // namespace

TEST_CASE("there is no force and the device is asked to home until all three arms have") {
    Pressing bench;
    bench.loop = {};
    for (const int flags : {0, 1, 2, 3, 4, 5, 6}) {
        bench.sense.homed = static_cast<std::uint8_t>(flags);
        bench.step(3);
        CHECK(bench.record.state == PAL_STATE_HOMING);
        CHECK(bench.drive.homing == 1);
        CHECK(bench.motors_are_zero());
        CHECK(bench.force_n() == 0.0);
    }
    bench.sense.homed = 7;
    bench.step();
    CHECK(bench.record.state == PAL_STATE_ENABLED);
    CHECK(bench.drive.homing == 0);
    CHECK_FALSE(bench.motors_are_zero());
    bench.sense.homed = 0;  // the flags mean nothing once homing is off
    bench.step();
    CHECK(bench.drive.homing == 0);
    CHECK_FALSE(bench.motors_are_zero());
}

TEST_CASE("after homing the force grows from zero over the ramp") {
    Pressing bench;
    bench.loop = {};
    bench.config.ramp_ticks = 100;
    double last = -1.0;
    for (int n = 0; n < 100; ++n) {
        bench.step();
        CHECK(bench.record.state == PAL_STATE_RAMP);
        CHECK(bench.record.gain == static_cast<float>(n) / 100.0F);
        CHECK(bench.force_n() > last);
        last = bench.force_n();
    }
    bench.step();
    CHECK(bench.record.state == PAL_STATE_ENABLED);
    CHECK(bench.record.gain == 1.0F);
}

TEST_CASE("an operator's pause is zero at once and ends with the ramp") {
    Pressing bench;
    bench.config.ramp_ticks = 50;
    bench.step(60);
    bench.sense.enable = 0;
    bench.step();
    CHECK(bench.record.state == PAL_STATE_PAUSED);
    CHECK(bench.motors_are_zero());
    bench.sense.enable = 1;
    bench.step();
    CHECK(bench.record.state == PAL_STATE_RAMP);
    CHECK(bench.record.gain == 0.0F);
}

TEST_CASE("emergency stop and a dead host are zero in the same tick and stay latched") {
    const auto fault = GENERATE(as<std::uint32_t>{}, PAL_FAULT_ESTOP, PAL_FAULT_HOST_LOST);
    Pressing bench;
    (fault == PAL_FAULT_ESTOP ? bench.sense.estop : bench.sense.host_lost) = 1;
    CHECK((bench.step() & fault) != 0);
    CHECK(bench.motors_are_zero());
    bench.sense.estop = bench.sense.host_lost = 0;
    bench.step(5000);
    CHECK(bench.record.stop == fault);
    CHECK(bench.record.state == PAL_STATE_FAULT);
    CHECK(bench.motors_are_zero());
    bench.sense.enable = 0;
    bench.step();
    bench.sense.enable = 1;
    bench.step();
    CHECK(bench.motors_are_zero());
}

TEST_CASE("late ticks hold the force, then fade it, then stop") {
    Pressing bench;
    const double held_n = bench.force_n();
    REQUIRE(held_n > 1.0);
    bench.sense.fresh = 0;
    for (int n = 1; n <= 20; ++n) {
        const std::uint32_t faults = bench.step();
        INFO("late tick " << n);
        CHECK((faults & PAL_FAULT_LATE) != 0);
        CHECK(((faults & PAL_FAULT_DEVICE_LOST) != 0) == (n >= 20));
        const double share = n <= 4 ? 1.0 : n < 20 ? 1.0 - (n - 4) / 16.0 : 0.0;
        CHECK(std::fabs(bench.force_n() - share * held_n) < 1.0e-5);
    }
    CHECK(bench.motors_are_zero());
    CHECK(bench.record.stop == PAL_FAULT_DEVICE_LOST);
}

TEST_CASE("four late ticks pass unnoticed, five end with the ramp") {
    for (const int n_late : {4, 5}) {
        Pressing bench;
        bench.config.ramp_ticks = 100;
        bench.step(110);
        bench.sense.fresh = 0;
        bench.step(n_late);
        bench.sense.fresh = 1;
        bench.step();
        CHECK((bench.record.state == PAL_STATE_RAMP) == (n_late == 5));
    }
}

TEST_CASE("a lost device comes back after its release ticks, with the ramp") {
    Pressing bench;
    bench.config.ramp_ticks = 10;
    bench.sense.fresh = 0;
    bench.step(25);
    bench.sense.fresh = 1;
    bench.step(199);
    CHECK(bench.record.state == PAL_STATE_FAULT);
    CHECK(bench.motors_are_zero());
    bench.step();
    CHECK(bench.record.state == PAL_STATE_RAMP);
    CHECK(bench.record.gain == 0.0F);
    bench.step(10);
    CHECK(bench.record.state == PAL_STATE_ENABLED);
}

TEST_CASE("without release ticks only an operator's pause releases a lost device") {
    Pressing bench;
    bench.config.release_ticks = 0;
    bench.sense.fresh = 0;
    bench.step(25);
    bench.sense.fresh = 1;
    bench.step(10000);
    CHECK(bench.record.stop == PAL_FAULT_DEVICE_LOST);
    bench.sense.enable = 0;
    bench.step();
    bench.sense.enable = 1;
    bench.step();
    CHECK(bench.record.stop == 0);
}

TEST_CASE("an emergency stop outranks a lost device that would release itself") {
    Pressing bench;
    bench.sense.fresh = 0;
    bench.step(25);
    bench.sense.estop = 1;
    bench.step();
    bench.sense.estop = 0;
    bench.sense.fresh = 1;
    bench.step(1000);
    CHECK(bench.record.stop == PAL_FAULT_ESTOP);
    CHECK(bench.motors_are_zero());
}

TEST_CASE("arms beyond their travel give no force in that tick and a ramp afterwards") {
    Pressing bench;
    bench.config.ramp_ticks = 50;
    bench.step(60);
    const pal_sense good = bench.sense;
    bench.sense.encoder_counts[1] = GENERATE(as<std::int16_t>{}, 32767, -32768, -1700, 1600);
    CHECK((bench.step() & PAL_FAULT_WORKSPACE) != 0);
    CHECK(bench.motors_are_zero());
    CHECK(std::fabs(bench.record.position_m[2] + 2.0e-3F) < 5.0e-5F);  // the last good one
    bench.sense = good;
    bench.step();
    CHECK(bench.faults == 0);
    CHECK(bench.record.state == PAL_STATE_RAMP);
}

TEST_CASE("sensed values that are not numbers give no force") {
    Pressing bench;
    pal_delta delta = PAL_DELTA_NF1;
    bench.config.delta = &delta;
    delta.counts_per_rad = GENERATE(as<float>{}, NAN, 0.0F);
    CHECK((bench.step() & PAL_FAULT_NOT_FINITE) != 0);
    CHECK(bench.motors_are_zero());
    delta.counts_per_rad = PAL_DELTA_NF1.counts_per_rad;
    CHECK(bench.step() == 0);
    CHECK_FALSE(bench.motors_are_zero());
}

TEST_CASE("a table that went bad after its check gives no force") {
    const float bad = GENERATE(as<float>{}, NAN, INFINITY, 1.0e30F);
    Pressing bench;
    for (std::uint32_t i = 0; i < 35 * 35; ++i) bench.table->coef[35 * 35 + i] = bad;
    CHECK((bench.step() & PAL_FAULT_NOT_FINITE) != 0);
    CHECK(bench.motors_are_zero());
    CHECK(bench.force_n() == 0.0);
}

TEST_CASE("no table: no force but damping, and that ends too") {
    LoopBench bench;
    CHECK((bench.step() & PAL_FAULT_TABLE_MISSING) != 0);
    CHECK(bench.motors_are_zero());
    bench.move(0.0, 0.0, 1.0e-3);
    bench.step();
    CHECK(bench.record.velocity_m_per_s[2] > 0.1F);
    CHECK(bench.record.force_n[2] == -2.0F * bench.record.velocity_m_per_s[2]);
    bench.step(548);
    bench.move(0.0, 0.0, 0.0);
    bench.step();
    CHECK(bench.motors_are_zero());
}

TEST_CASE("a tool that leaves the table gets no table force, only damping") {
    Pressing bench;
    bench.move(9.7e-3, 0.0, -2.0e-3);
    bench.step(100);
    bench.move(10.3e-3, 0.0, -2.0e-3);
    CHECK((bench.step() & PAL_FAULT_TABLE_LEFT) != 0);
    CHECK(bench.record.table_force_n[2] == 0.0F);
    CHECK(bench.record.force_n[0] < 0.0F);  // against the motion
    CHECK(bench.record.depth_m == 0.0F);
    CHECK(bench.record.k_n_per_m == 0.0F);
}

TEST_CASE("a stale table is damped, an old one dropped over fifty ticks") {
    Pressing bench;  // taken at tick 0
    bench.step(99);
    CHECK(bench.faults == 0);
    CHECK((bench.step() & PAL_FAULT_TABLE_STALE) != 0);
    CHECK(bench.record.table_age_ticks == 100);
    CHECK(bench.record.gain == 1.0F);
    bench.step(399);
    CHECK((bench.faults & PAL_FAULT_TABLE_DROPPED) == 0);
    CHECK((bench.step() & PAL_FAULT_TABLE_DROPPED) != 0);
    bench.step(25);
    CHECK(std::fabs(bench.record.gain - 0.5F) < 1.0e-6F);
    CHECK(std::fabs(bench.force_n() - 0.8) < 0.05);
    bench.step(25);
    CHECK(bench.motors_are_zero());
    // A newer table in contact: the ramp, not a jump.
    bench.config.ramp_ticks = 100;
    const auto newer = tables::make({}, 33, 0.0, 2);
    bench.given.now = newer.get();
    bench.loop.ramp_tick = 100;
    bench.step();
    CHECK(bench.faults == 0);
    CHECK(bench.record.state == PAL_STATE_RAMP);
    CHECK(bench.record.gain == 0.0F);
}

TEST_CASE("a stale table damps the motion") {
    Pressing still;
    still.step(150);
    Pressing moving;
    moving.move(0.0, 0.0, -1.0e-3);
    moving.step(149);
    moving.move(0.0, 0.0, -2.0e-3);
    moving.step();
    CHECK(moving.record.velocity_m_per_s[2] < -0.1F);
    CHECK(std::fabs(moving.record.force_n[2] - moving.record.table_force_n[2] +
                    2.0F * moving.record.velocity_m_per_s[2]) < 1.0e-4F);
}

TEST_CASE("without contact a table that comes back needs no ramp") {
    Pressing bench;
    bench.config.ramp_ticks = 100;
    bench.step(110);
    bench.move(0.0, 0.0, 1.0e-3);
    bench.given.now = nullptr;
    bench.step();
    bench.given.now = bench.table.get();
    bench.step();
    CHECK(bench.record.state == PAL_STATE_ENABLED);
}

TEST_CASE("a refused table is reported once") {
    Pressing bench;
    bench.given.n_bad = 1;
    CHECK((bench.step() & PAL_FAULT_TABLE_BAD) != 0);
    CHECK((bench.step() & PAL_FAULT_TABLE_BAD) == 0);
    CHECK_FALSE(bench.motors_are_zero());
}

TEST_CASE("a table with a broken header is as good as none") {
    Pressing bench;
    bench.table->magic = 0;
    const std::uint32_t faults = bench.step();
    CHECK((faults & PAL_FAULT_TABLE_MISSING) != 0);
    CHECK((faults & PAL_FAULT_TABLE_BAD) != 0);
    CHECK(bench.motors_are_zero());
}
