#include "firmware/core/step.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <limits>
#include <random>

#include "tests/firmware/loop_bench.hpp"

namespace {

std::unique_ptr<pal_table> skin(double k_n_per_m, std::uint64_t id, double raised_m = 0.0) {
    tables::Fields fields;
    fields.k_n_per_m = [=](double, double) { return k_n_per_m; };
    fields.s_m = [=](double, double) { return raised_m; };
    return tables::make(fields, 33, 0.0, id);
}

/// Force that the motor words make, by virtual work through the Jacobian.
std::array<double, 3> motor_force_n(const LoopBench& bench) {
    float jacobian[9];
    if (!pal_delta_jacobian(bench.config.delta, bench.loop.position_m, jacobian))
        throw std::logic_error("jacobian");
    std::array<double, 3> force{};
    for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t i = 0; i < 3; ++i) {
            force[c] -= static_cast<double>(jacobian[3 * i + c]) * bench.drive.motor_counts[i] /
                        static_cast<double>(bench.config.delta->units_per_n_m);
        }
    }
    return force;
}

}  // namespace

TEST_CASE("the motors make the force that the table says, to the rounding of a motor word") {
    LoopBench bench;
    const auto table = skin(800.0, 1);
    bench.given.now = table.get();
    for (const double depth_m : {1.0e-3, 2.0e-3, 4.0e-3}) {
        bench.move(3.0e-3, -2.0e-3, -depth_m);
        CHECK(bench.step() == 0);
        const auto made_n = motor_force_n(bench);
        CHECK(std::fabs(static_cast<double>(bench.record.depth_m) - depth_m) <
              3.0e-5);  // one encoder count is 48 um
        CHECK(std::fabs(made_n[2] - 800.0 * static_cast<double>(bench.record.depth_m)) < 0.01);
        CHECK(std::fabs(made_n[0]) < 0.01);
        CHECK(std::fabs(made_n[1]) < 0.01);
        CHECK(std::fabs(bench.record.k_n_per_m - 800.0F) < 1.0e-3F);
    }
}

TEST_CASE("a force above the limit is cut in length and keeps its direction") {
    LoopBench bench;
    tables::Fields fields;
    fields.s_m = [](double u, double) { return 0.5 * u; };
    fields.k_n_per_m = [](double, double) { return 3000.0; };
    const auto table = tables::make(fields);
    bench.given.now = table.get();
    bench.config.force_max_n = 4.0F;
    bench.move(0.0, 0.0, -4.0e-3);
    CHECK((bench.step() & PAL_FAULT_FORCE_CLAMP) != 0);
    CHECK(std::fabs(bench.force_n() - 4.0) < 1.0e-5);
    const pal_tick& r = bench.record;
    CHECK(std::fabs(r.force_n[0] / r.force_n[2] - r.table_force_n[0] / r.table_force_n[2]) < 1.0e-6F);
    CHECK(r.force_n[0] < -1.0F);
}

TEST_CASE("a force limit of next to nothing gives no motor words and no fault but the clamp") {
    // 0: what a stand makes of a scene's 1e-300 N.
    const float limit_n = GENERATE(as<float>{}, 1.0e-9F, std::numeric_limits<float>::min(), 0.0F);
    LoopBench bench;
    const auto table = skin(800.0, 1);
    bench.given.now = table.get();
    bench.config.force_max_n = limit_n;
    bench.move(0.0, 0.0, -2.0e-3);
    CHECK(bench.step() == PAL_FAULT_FORCE_CLAMP);
    CHECK(bench.motors_are_zero());
    CHECK(bench.force_n() <= 1.0001 * static_cast<double>(limit_n));
}

TEST_CASE("motor words beyond the limit are scaled together, so the direction stays") {
    LoopBench bench;
    pal_delta weak = PAL_DELTA_NF1;
    weak.motor_max = 300;
    bench.config.delta = &weak;
    tables::Fields fields;
    fields.s_m = [](double u, double v) { return 0.5 * u + 0.3 * v; };
    fields.k_n_per_m = [](double, double) { return 1500.0; };
    const auto table = tables::make(fields);
    bench.given.now = table.get();
    bench.move(0.0, 0.0, -4.0e-3);
    CHECK((bench.step() & PAL_FAULT_MOTOR_CLAMP) != 0);
    int largest = 0;
    for (const std::int16_t word : bench.drive.motor_counts) largest = std::max(largest, std::abs(int{word}));
    CHECK(largest == 300);
    const auto made_n = motor_force_n(bench);
    for (std::size_t c = 0; c < 3; ++c) {
        CHECK(std::fabs(made_n[c] - static_cast<double>(bench.record.force_n[c])) < 0.02);
        CHECK(std::fabs(made_n[c] / made_n[2] - static_cast<double>(bench.record.table_force_n[c]) /
                                                    static_cast<double>(bench.record.table_force_n[2])) <
              0.01);
    }
}

TEST_CASE("a new table fades in over its ticks without a jump and its work is booked") {
    LoopBench bench;
    const auto soft = skin(500.0, 1);
    const auto stiff = skin(800.0, 2);
    bench.given.now = soft.get();
    bench.move(0.0, 0.0, -2.0e-3);
    bench.step(3);
    const double depth_m = static_cast<double>(bench.record.depth_m);
    double last_n = bench.force_n();
    bench.given = {stiff.get(), soft.get(), 0};
    for (int n = 1; n <= 16; ++n) {
        CHECK(bench.step() == 0);
        const double x = n / 16.0;
        const double weight = x * x * (3.0 - 2.0 * x);
        CHECK(std::fabs(bench.force_n() - (500.0 + 300.0 * weight) * depth_m) < 1.0e-4);
        CHECK(std::fabs(bench.force_n() - last_n) < 0.06);  // 0.6 N in all, at most 1.5/16 of it at once
        CHECK(bench.record.table_id == 2);
        CHECK(bench.record.before_id == (n < 16 ? 1U : 0U));
        CHECK(pal_loop_fading(&bench.config, &bench.loop) == (n < 16));
        last_n = bench.force_n();
    }
    CHECK(std::fabs(static_cast<double>(bench.record.fade_work_j) - 150.0 * depth_m * depth_m) < 1.0e-8);
    bench.step(5);
    CHECK(std::fabs(bench.force_n() - 800.0 * depth_m) < 1.0e-4);
}

TEST_CASE("the old table's last answer holds when the tool leaves it during the fade") {
    LoopBench bench;
    const auto old = skin(800.0, 1);
    const auto next = skin(800.0, 2);
    next->p0_m[0] = 5.0e-3F;
    pal_table_seal(next.get());
    bench.given.now = old.get();
    bench.move(9.9e-3, 0.0, -2.0e-3);
    bench.step(2);
    const double before_n = static_cast<double>(bench.record.table_force_n[2]);
    bench.given = {next.get(), old.get(), 0};
    bench.move(10.3e-3, 0.0, -2.0e-3);
    for (int n = 0; n < 16; ++n) {
        CHECK(bench.step() == 0);
        CHECK(std::fabs(static_cast<double>(bench.record.table_force_n[2]) - before_n) < 0.03);
    }
}

TEST_CASE("a table that arrives during late ticks still fades") {
    LoopBench bench;
    const auto soft = skin(500.0, 1);
    const auto stiff = skin(800.0, 2);
    bench.given.now = soft.get();
    bench.move(0.0, 0.0, -2.0e-3);
    bench.step(3);
    bench.given = {stiff.get(), soft.get(), 0};
    bench.sense.fresh = 0;
    bench.step(2);
    CHECK(pal_loop_fading(&bench.config, &bench.loop));
    bench.sense.fresh = 1;
    const double before_n = bench.force_n();
    bench.step();
    CHECK(std::fabs(bench.force_n() - before_n) < 0.02);
}

TEST_CASE("pressing in gives the hand minus the stored energy") {
    LoopBench bench;
    const auto table = skin(800.0, 1);
    bench.given.now = table.get();
    bench.move(0.0, 0.0, 0.0);
    bench.step(3);
    for (int n = 1; n <= 400; ++n) {
        bench.move(0.0, 0.0, -4.0e-3 * n / 400.0);
        bench.step();
    }
    const double stored_j = static_cast<double>(bench.record.potential_j);
    CHECK(std::fabs(stored_j - 6.4e-3) < 2.0e-4);
    // Held forces: the hand gets K dx^2/2 too much in each tick of travel dx.
    CHECK(std::fabs(static_cast<double>(bench.record.hand_work_j) + stored_j) < 0.02 * stored_j);
}

TEST_CASE("the velocity is the slope of a steady motion") {
    LoopBench bench;
    const auto table = skin(800.0, 1);
    bench.given.now = table.get();
    double mean = 0.0;
    for (int n = 0; n < 250; ++n) {
        bench.move(0.0, 0.0, 5.0e-3 + 1.0e-4 * n);
        bench.step();
        if (n >= 150) mean += static_cast<double>(bench.record.velocity_m_per_s[2]) / 100.0;
    }
    CHECK(std::fabs(mean - 0.1) < 2.0e-3);
}

TEST_CASE("the record keeps what belongs to its caller") {
    LoopBench bench;
    bench.record.t_ns = 123;
    bench.record.n_missed = 7;
    bench.record.truth_valid = 1;
    bench.record.truth_force_n[2] = 3.0F;
    bench.record.stamp_ns[5] = 9;
    bench.record.path_tick = 11;
    bench.step(3);
    CHECK(bench.record.tick == 2);
    CHECK(bench.record.t_ns == 123);
    CHECK(bench.record.n_missed == 7);
    CHECK(bench.record.truth_valid == 1);
    CHECK(bench.record.truth_force_n[2] == 3.0F);
    CHECK(bench.record.stamp_ns[5] == 9);
    CHECK(bench.record.path_tick == 11);
}

TEST_CASE("whatever is sensed, the motors stay within their limit and the force within its own") {
    LoopBench bench;
    tables::Fields fields;
    fields.k_n_per_m = [](double u, double) { return 3000.0 + 1.0e5 * u; };
    const auto first = tables::make(fields, 33, 20.0, 1);
    const auto second = tables::make(fields, 33, -20.0, 2);
    std::mt19937 random(5);
    for (int n = 0; n < 200000; ++n) {
        const auto r = random();
        if (r % 3 == 0) {
            for (std::int16_t& c : bench.sense.encoder_counts)
                c = static_cast<std::int16_t>(random() % 2600 - 1500);
        }
        bench.sense.fresh = r % 7 != 0;
        bench.sense.enable = r % 101 != 0;
        if (r % 50 == 0)
            bench.given = {r % 100 == 0 ? first.get() : second.get(),
                           r % 100 == 0 ? second.get() : first.get(), 0};
        if (r % 997 == 0) bench.given.now = nullptr;
        bench.step();
        REQUIRE(bench.force_n() <= 8.00001);
        for (const std::int16_t word : bench.drive.motor_counts) REQUIRE(std::abs(int{word}) <= 4095);
    }
}

TEST_CASE("two loops with the same input give the same bits") {
    LoopBench a;
    LoopBench b;
    const auto table = tables::make({}, 33, 25.0);
    a.given.now = b.given.now = table.get();
    for (int n = 0; n < 2000; ++n) {
        const double depth_m = 3.0e-3 * (n % 200) / 200.0;
        a.move(1.0e-3, 2.0e-3, -depth_m);
        b.sense = a.sense;
        a.step();
        b.step();
        REQUIRE(std::memcmp(&a.record, &b.record, sizeof a.record) == 0);
    }
}
