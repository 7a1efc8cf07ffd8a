#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>

#include "host/latency/measure.hpp"
#include "tests/host/latency/run.hpp"

using namespace palpate::latency;
using Catch::Matchers::Contains;

namespace {

/// All samples equal.
void check_all(const Quantity& quantity, std::uint64_t n, std::uint64_t ns) {
    CHECK(quantity.known());
    CHECK(quantity.histogram.n() == n);
    CHECK(quantity.histogram.min_ns() == ns);
    CHECK(quantity.histogram.max_ns() == ns);
}

}  // namespace

TEST_CASE("each stage of the tick is measured between its own stamps") {
    const Measured m = measure(sample::run(50), {});
    CHECK(m.n_ticks == 50);
    CHECK(m.duration_s == Approx(0.049));
    CHECK_FALSE(m.virtual_time);
    check_all(m.period, 49, 1000000);
    check_all(m.wake_up, 50, 10000);
    check_all(m.wake_up_raw, 50, 10000);
    check_all(m.tick_cost, 50, 23000);
    check_all(m.collect, 50, 5000);
    check_all(m.choose_table, 50, 1000);
    check_all(m.compute_force, 50, 14000);
    check_all(m.hand_over, 50, 3000);
    check_all(m.sensor_to_force, 50, 18000);
    check_all(m.sensor_age_bound, 49, 1000000);
    check_all(m.request_done, 49, 400000);
    CHECK(m.n_missed == 0);
    CHECK(m.n_missed_not_late == 0);
    CHECK(m.reply_share == 1.0);
    CHECK_FALSE(m.reply_share_min.has_value());
}

TEST_CASE("a stall of three periods counts as four late starts and three missed periods") {
    auto ticks = sample::run(20);
    for (std::size_t i = 10; i < 20; ++i) {  // the loop's clock skips what has passed
        sample::shift(ticks[i], 3000000);
        ticks[i].n_missed = 3;
        ticks[i].stamp_ns[5] += 3000000;
    }
    sample::shift(ticks[10], -10000 + 250000);  // programmed at tick 10's old place, woken 3.25 ms later
    ticks[10].wake_late_ns = 3250000;
    ticks[10].stamp_ns[5] = ticks[9].stamp_ns[4] + 400000;
    ticks[11].stamp_ns[5] = ticks[10].stamp_ns[4] + 400000;
    const Measured m = measure(ticks, {});
    CHECK(m.n_missed == 3);
    CHECK(m.longest_miss == 3);
    CHECK(m.n_missed_not_late == 0);
    CHECK(m.wake_up_raw.histogram.n() == 20);
    CHECK(m.wake_up.histogram.n() == 23);  // 3250, 2250, 1250 and 250 us in the place of one
    CHECK(m.wake_up.histogram.max_ns() == 3250000);
    CHECK(m.wake_up.histogram.mean_ns() == Approx((19 * 10000.0 + 3250e3 + 2250e3 + 1250e3 + 250e3) / 23));
    CHECK(m.period.histogram.max_ns() == 1000000 + 3240000);
}

TEST_CASE("missed periods that no late start explains are counted apart; the longest run is found") {
    auto ticks = sample::run(30);
    for (std::size_t i = 5; i < 30; ++i) ticks[i].n_missed = i < 9 ? 1 : i < 20 ? 6 : 8;
    const Measured m = measure(ticks, {});
    CHECK(m.n_missed == 8);
    CHECK(m.longest_miss == 5);
    CHECK(m.n_missed_not_late == 8);
}

TEST_CASE("periods that were missed before the first record are not of this run") {
    auto ticks = sample::run(5);
    for (pal_tick& tick : ticks) tick.n_missed = 40;
    ticks[0].wake_late_ns = 40000000;
    CHECK(measure(ticks, {}).n_missed == 0);
    CHECK(measure(ticks, {}).n_missed_not_late == 0);
}

TEST_CASE("a tick without a fresh sample has no sensor-to-force and lowers the share of replies") {
    auto ticks = sample::run(200);
    for (std::size_t i = 50; i < 60; ++i) ticks[i].faults = PAL_FAULT_LATE;
    const Measured m = measure(ticks, {});
    CHECK(m.n_replies == 190);
    REQUIRE(m.reply_share.has_value());
    CHECK(*m.reply_share == Approx(0.95));
    REQUIRE(m.reply_share_min.has_value());
    CHECK(*m.reply_share_min == Approx(0.90));
    CHECK(m.sensor_to_force.histogram.n() == 190);
    CHECK(m.sensor_age_bound.histogram.n() == 189);
    CHECK(m.tick_cost.histogram.n() == 200);
}

TEST_CASE("in virtual time every clock is not known, with the reason, and nothing is 0") {
    auto ticks = sample::run(10, 0);
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        std::memset(ticks[i].stamp_ns, 0, sizeof ticks[i].stamp_ns);
        ticks[i].t_ns = i * 1000000;
    }
    const Measured m = measure(ticks, {});
    CHECK(m.virtual_time);
    for (const QuantityName& name : quantity_names()) {
        CAPTURE(name.key);
        if (std::string(name.key) == "period") continue;  // of virtual time, and exact
        CHECK_FALSE((m.*name.member).known());
        CHECK_THAT((m.*name.member).why_unknown, Contains("virtual time") || Contains("no table"));
        CHECK((m.*name.member).histogram.n() == 0);
    }
}

TEST_CASE("a stamp that is missing is named and counted, on every tick or on one") {
    const int which = GENERATE(0, 1, 2, 3, 4, 5);
    auto ticks = sample::run(10);
    SECTION("on every tick") {
        for (pal_tick& tick : ticks) tick.stamp_ns[which] = 0;
        const Measured m = measure(ticks, {});
        const std::string name = "T" + std::to_string(which);
        const auto check = [&](const Quantity& quantity, std::initializer_list<int> needs) {
            const bool needed = std::find(needs.begin(), needs.end(), which) != needs.end();
            CHECK(quantity.known() != needed);
            if (needed) CHECK_THAT(quantity.why_unknown, Contains("did not stamp " + name));
        };
        check(m.tick_cost, {1, 4});
        check(m.collect, {0, 1});
        check(m.choose_table, {1, 2});
        check(m.compute_force, {2, 3});
        check(m.hand_over, {3, 4});
        check(m.sensor_to_force, {0, 4});
        check(m.sensor_age_bound, {4});
        check(m.request_done, {4, 5});
    }
    SECTION("on one") {
        ticks[4].stamp_ns[which] = 0;
        const Measured m = measure(ticks, {});
        CHECK(m.tick_cost.histogram.n() == (which == 1 || which == 4 ? 9 : 10));
        CHECK(m.tick_cost.n_unknown == (which == 1 || which == 4 ? 1 : 0));
        CHECK(m.tick_cost.known());
    }
}

TEST_CASE("stamps out of order are no negative times") {
    auto ticks = sample::run(10);
    for (pal_tick& tick : ticks) std::swap(tick.stamp_ns[2], tick.stamp_ns[3]);
    const Measured m = measure(ticks, {});
    CHECK_FALSE(m.compute_force.known());
    CHECK_THAT(m.compute_force.why_unknown, Contains("never in order"));
    CHECK(m.compute_force.n_unknown == 10);
}

TEST_CASE("a loop that does not write its lateness has no wake-up, not a perfect one") {
    const Measured m = measure(sample::run(10, 0), {});
    CHECK_FALSE(m.wake_up.known());
    CHECK_THAT(m.wake_up.why_unknown, Contains("programmed starts"));
    CHECK_FALSE(m.wake_up_raw.known());
    CHECK(m.tick_cost.known());
}

TEST_CASE("lost records are counted and nothing is measured across the gap") {
    auto ticks = sample::run(20);
    ticks.erase(ticks.begin() + 7, ticks.begin() + 11);
    const Measured m = measure(ticks, {});
    CHECK(m.n_lost_records == 4);
    check_all(m.period, 14, 1000000);
    check_all(m.sensor_age_bound, 14, 1000000);
    check_all(m.request_done, 14, 400000);
}

TEST_CASE("records that go back in time or repeat are left out and counted") {
    auto ticks = sample::run(20);
    ticks.insert(ticks.begin() + 12, ticks[3]);
    ticks.insert(ticks.begin() + 5, ticks[4]);
    const Measured m = measure(ticks, {});
    CHECK(m.n_bad_records == 2);
    CHECK(m.n_ticks == 20);
    CHECK(m.n_lost_records == 0);
    check_all(m.period, 19, 1000000);
}

TEST_CASE("a request that is still under way, or that completed two ticks ago, is not measured") {
    auto ticks = sample::run(10);
    ticks[5].stamp_ns[5] = ticks[4].stamp_ns[5];                     // nothing new
    ticks[7].stamp_ns[5] = ticks[5].stamp_ns[4] + 1200000 - 250000;  // tick 5's, before tick 6's hand-over
    const Measured m = measure(ticks, {});
    CHECK(m.request_done.n_unknown == 2);
    check_all(m.request_done, 7, 400000);
}

TEST_CASE("a reply that was there before the tick makes the sample older, and no stage negative") {
    auto ticks = sample::run(10);
    for (pal_tick& tick : ticks) tick.stamp_ns[0] = tick.stamp_ns[1] - 600000;
    const Measured m = measure(ticks, {});
    check_all(m.sensor_to_force, 10, 623000);
    check_all(m.choose_table, 10, 6000);
    CHECK_THAT(m.collect.why_unknown, Contains("before the tick began"));
    check_all(m.tick_cost, 10, 23000);
}

TEST_CASE("packets that pass in the call have no completion of their own; a later one is measured") {
    auto ticks = sample::run(10);
    SECTION("in the call") {
        for (pal_tick& tick : ticks) tick.stamp_ns[5] = tick.stamp_ns[4];
        CHECK_THAT(measure(ticks, {}).request_done.why_unknown, Contains("in the very call"));
    }
    SECTION("of its own request") {
        for (pal_tick& tick : ticks) tick.stamp_ns[5] = tick.stamp_ns[4] + 2000;
        check_all(measure(ticks, {}).request_done, 9, 2000);
    }
    SECTION("the device took no more") {
        ticks[5].stamp_ns[4] = 0;
        const Measured m = measure(ticks, {});
        CHECK(m.tick_cost.n_unknown == 1);
        CHECK(m.request_done.n_unknown == 1);  // that of tick 5, which was never handed over
        CHECK(m.sensor_age_bound.n_unknown == 2);
    }
}

TEST_CASE("after ticks without a reply the sample may answer the request of the last tick that had one") {
    auto ticks = sample::run(20);
    for (std::size_t i = 5; i < 8; ++i) ticks[i].faults = PAL_FAULT_LATE;
    const Measured m = measure(ticks, {});
    CHECK(m.sensor_age_bound.histogram.n() == 16);
    CHECK(m.sensor_age_bound.histogram.max_ns() == 4000000);  // tick 8 against tick 4
    ticks.erase(ticks.begin() + 3, ticks.begin() + 6);        // the last one with a reply is not known now
    CHECK(measure(ticks, {}).sensor_age_bound.n_unknown == 1);
}

TEST_CASE("no ticks at all: everything is not known, and why") {
    const Measured m = measure({}, {});
    CHECK(m.n_ticks == 0);
    for (const QuantityName& name : quantity_names()) {
        CHECK_THAT((m.*name.member).why_unknown, Contains("no ticks"));
    }
}

TEST_CASE("the loop's words are copied as they stand") {
    pal_link_loop loop{};
    loop.realtime = 37, loop.realtime_refused = 64, loop.n_minor_faults = 3, loop.n_major_faults = 1;
    loop.n_preempted = 9;
    const LoopWords words = loop_words(loop);
    CHECK(words.granted == 37);
    CHECK(words.refused == 64);
    CHECK(words.n_minor_faults == 3);
    CHECK(words.n_major_faults == 1);
    CHECK(words.n_preempted == 9);
}
