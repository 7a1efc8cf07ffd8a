#include <catch2/catch.hpp>
#include <cstring>

#include "host/latency/verdict.hpp"
#include "tests/host/latency/run.hpp"

using namespace palpate::latency;
using Catch::Matchers::Contains;

namespace {

std::string all(const Verdict& verdict) {
    std::string out;
    for (const std::string& reason : verdict.reasons) out += reason + '\n';
    return out;
}

/// 10 000 starts, `n_late` of them this late.
std::vector<pal_tick> run_with_late(std::size_t n_late, std::uint32_t late_ns) {
    auto ticks = sample::run(10000, 20000);
    for (std::size_t i = 0; i < n_late; ++i) {
        sample::shift(ticks[1000 + i * 10], std::int64_t{late_ns} - 20000);
        ticks[1000 + i * 10].wake_late_ns = late_ns;
    }
    return ticks;
}

}  // namespace

TEST_CASE("the machine is suitable while 99.9 % of the starts are within 300 us, and marginal beyond") {
    // Ranks: 9990 of 10000. With 10 late ones the 9990th is still good, with 11 it is not.
    CHECK(judge(measure(run_with_late(10, 900000), {}), 0.0).suitability == Suitability::SUITABLE);
    const Verdict verdict = judge(measure(run_with_late(11, 900000), {}), 0.0);
    CHECK(verdict.suitability == Suitability::MARGINAL);
    CHECK_THAT(all(verdict), Contains("p99.9 of the wake-up is 900.0 us"));
    // 300.0 us as the bin's largest is within, 301 us is not.
    CHECK(judge(measure(run_with_late(11, 300000), {}), 0.0).suitability == Suitability::SUITABLE);
    CHECK(judge(measure(run_with_late(11, 301000), {}), 0.0).suitability == Suitability::MARGINAL);
}

TEST_CASE("one start a period late, a missed period or too few replies make it not suitable") {
    SECTION("late") {
        CHECK(judge(measure(run_with_late(1, 1000000), {}), 0.0).suitability == Suitability::SUITABLE);
        const Verdict verdict = judge(measure(run_with_late(1, 1000001), {}), 0.0);
        CHECK(verdict.suitability == Suitability::NOT_SUITABLE);
        CHECK_THAT(all(verdict), Contains("latest start"));
    }
    SECTION("missed") {
        auto ticks = sample::run(2000);
        for (std::size_t i = 100; i < 2000; ++i) ticks[i].n_missed = 2;
        const Verdict verdict = judge(measure(ticks, {}), 0.0);
        CHECK(verdict.suitability == Suitability::NOT_SUITABLE);
        CHECK_THAT(all(verdict), Contains("2 periods went without a tick, up to 2 in a row"));
    }
    SECTION("replies") {
        auto ticks = sample::run(2000);
        for (std::size_t i = 0; i < 100; ++i) ticks[i].faults = PAL_FAULT_LATE;
        CHECK(judge(measure(ticks, {}), 0.0).suitability == Suitability::SUITABLE);
        ticks[100].faults = PAL_FAULT_LATE;
        const Verdict verdict = judge(measure(ticks, {}), 0.0);
        CHECK(verdict.suitability == Suitability::NOT_SUITABLE);
        CHECK_THAT(all(verdict), Contains("94.95 % of the ticks"));
    }
}

TEST_CASE("nothing is judged from too little") {
    CHECK(judge(measure(sample::run(999), {}), 0.0).suitability == Suitability::NOT_KNOWN);
    CHECK_THAT(all(judge(measure(sample::run(999), {}), 0.0)), Contains("only 999 starts"));
    CHECK(judge(measure(sample::run(1000), {}), 0.0).suitability == Suitability::SUITABLE);
    CHECK(judge(measure({}, {}), 0.0).suitability == Suitability::NOT_KNOWN);
    CHECK_THAT(all(judge(measure(sample::run(2000, 0), {}), 0.0)), Contains("wake-up is not known"));
    auto virtual_ticks = sample::run(2000, 0);
    for (pal_tick& tick : virtual_ticks) std::memset(tick.stamp_ns, 0, sizeof tick.stamp_ns);
    const Verdict verdict = judge(measure(virtual_ticks, {}), 0.0);
    CHECK(verdict.suitability == Suitability::NOT_KNOWN);
    CHECK_THAT(all(verdict), Contains("virtual time"));
}

TEST_CASE(
    "a run from which the hypervisor stole is marked not valid, and so is one of which that is not known") {
    const Measured measured = measure(sample::run(2000), {});
    CHECK(judge(measured, 0.0).not_valid.empty());
    CHECK_THAT(judge(measured, 0.01).not_valid, Contains("not valid for latency") && Contains("0.01 s"));
    CHECK_THAT(judge(measured, std::nullopt).not_valid, Contains("not known"));
    CHECK(judge(measured, 0.01).suitability == Suitability::SUITABLE);
}
