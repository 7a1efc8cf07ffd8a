// Periods that passed without a tick count as ticks without a sample. The truth is the same loop, ticked.
#include <catch2/catch.hpp>

#include "tests/firmware/loop_bench.hpp"

namespace {

/// 2 mm below a flat skin of 800 N/m, settled, 1.6 N.
struct Pressing : LoopBench {
    std::unique_ptr<pal_table> table = tables::make();
    Pressing() {
        config.ramp_ticks = 100;
        given.now = table.get();
        move(0.0, 0.0, -2.0e-3);
        step(110);
    }
    /// `n` periods without a sample: each in a tick of its own, or all missed and told to the next tick.
    void lose(std::uint32_t n, bool ticked) {
        if (!ticked) {
            sense.n_missed = n;
            return;
        }
        sense.fresh = 0;
        step(static_cast<int>(n));
        sense.fresh = 1;
    }
    std::uint32_t tick() {
        const std::uint32_t result = step();
        sense.n_missed = 0;
        return result;
    }
};

}  // namespace

TEST_CASE("missed periods do to the force what as many late ticks do") {
    const auto n = GENERATE(range(0U, 40U));
    const auto release_ticks = GENERATE(as<std::uint32_t>{}, 0, 30);
    INFO("missed " << n);
    Pressing ticked, missed;
    ticked.config.release_ticks = missed.config.release_ticks = release_ticks;
    const auto softer = tables::make({.k_n_per_m = [](double, double) { return 500.0; }}, 33, 0.0, 2);
    if (GENERATE(false, true)) {  // in mid-fade
        for (Pressing* bench : {&ticked, &missed}) {
            bench->given = {softer.get(), bench->table.get(), 0};
            bench->step(6);
            REQUIRE(pal_loop_fading(&bench->config, &bench->loop));
        }
    }
    ticked.lose(n, true);
    missed.lose(n, false);
    for (int i = 0; i < 200; ++i) {
        ticked.move(0.0, 0.0, -2.0e-3 + 1.0e-5 * i);
        missed.move(0.0, 0.0, -2.0e-3 + 1.0e-5 * i);
        CHECK(ticked.tick() == missed.tick());
        CHECK(ticked.record.state == missed.record.state);
        CHECK(ticked.record.stop == missed.record.stop);
        CHECK(ticked.record.gain == missed.record.gain);
        CHECK(ticked.record.table_age_ticks == missed.record.table_age_ticks);
        for (int c = 0; c < 3; ++c) {
            CHECK(ticked.record.force_n[c] == missed.record.force_n[c]);
            CHECK(ticked.record.velocity_m_per_s[c] == missed.record.velocity_m_per_s[c]);
            CHECK(ticked.record.motor_counts[c] == missed.record.motor_counts[c]);
        }
    }
}

TEST_CASE("four missed periods pass, five end with the ramp, twenty latch") {
    for (const std::uint32_t n : {1U, 4U, 5U, 19U, 20U, 30U, 100000U}) {
        Pressing bench;
        const double before_n = bench.force_n();
        bench.lose(n, false);
        const std::uint32_t faults = bench.tick();
        INFO("missed " << n);
        CHECK(((faults & PAL_FAULT_DEVICE_LOST) != 0) == (n >= 20));
        CHECK(bench.record.state == (n < 5 ? PAL_STATE_ENABLED : n < 20 ? PAL_STATE_RAMP : PAL_STATE_FAULT));
        if (n < 5) {
            CHECK(bench.force_n() == before_n);
        } else {
            CHECK(bench.force_n() == 0.0);
            CHECK(bench.motors_are_zero());
        }
    }
}

TEST_CASE("after a stall of thirty periods the force comes back over the ramp alone") {
    Pressing bench;
    const double full_n = bench.force_n();
    bench.lose(30, false);
    int n_zero = 0;
    double last_n = 0.0;
    for (int n = 0; n < 310; ++n) {
        bench.tick();
        CHECK(bench.force_n() <= last_n + full_n / 99.0);
        last_n = bench.force_n();
        if (bench.motors_are_zero()) ++n_zero;
    }
    CHECK(n_zero == 200);  // 199 in the latch, and the ramp's first
    CHECK(std::fabs(last_n - full_n) < 1.0e-6);
}

TEST_CASE("missed periods and ticks without a sample add up") {
    Pressing bench;
    bench.sense.fresh = 0;
    bench.step(10);
    bench.sense.n_missed = 8;
    CHECK((bench.tick() & PAL_FAULT_DEVICE_LOST) == 0);  // 19
    const double fade = bench.force_n();
    CHECK(fade > 0.0);
    CHECK((bench.tick() & PAL_FAULT_DEVICE_LOST) != 0);
    CHECK(bench.motors_are_zero());
}

TEST_CASE("the count of late ticks does not wrap") {
    Pressing bench;
    bench.sense.fresh = 0;
    bench.step(10);
    bench.lose(0xFFFFFFFFU, false);
    CHECK((bench.tick() & PAL_FAULT_DEVICE_LOST) != 0);
    CHECK(bench.motors_are_zero());
}

TEST_CASE("a table is older by the periods that were missed, however many") {
    Pressing bench;
    const std::uint32_t age = bench.record.table_age_ticks;
    bench.lose(4, false);
    bench.tick();
    CHECK(bench.record.table_age_ticks == age + 5);
    bench.lose(0xFFFFFFFFU, false);
    CHECK((bench.tick() & PAL_FAULT_TABLE_DROPPED) != 0);
    CHECK(bench.motors_are_zero());
}
