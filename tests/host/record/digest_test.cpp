#include <catch2/catch.hpp>

#include "tests/host/record/sample.hpp"

using namespace palpate;

namespace {

struct Both {
    std::string io, state;
};

Both digests(const std::vector<pal_tick>& ticks, const pal_table& table) {
    record::Digest digest;
    for (const pal_tick& tick : ticks) digest.tick(tick);
    digest.table(table);
    return {digest.io(), digest.state()};
}

}  // namespace

TEST_CASE("an empty digest is XXH64 of nothing") {
    const record::Digest digest;
    CHECK(digest.io() == "ef46db3751d8e999");  // from the definition of XXH64, seed 0
    CHECK(digest.state() == "ef46db3751d8e999");
}

TEST_CASE("equal runs have equal digests") {
    const Both a = digests(sample::ticks(50), *sample::table(1)),
               b = digests(sample::ticks(50), *sample::table(1));
    CHECK(a.io == b.io);
    CHECK(a.state == b.state);
    CHECK(a.io != a.state);
}

TEST_CASE("one encoder count of one tick changes both digests") {
    const Both before = digests(sample::ticks(50), *sample::table(1));
    auto ticks = sample::ticks(50);
    ++ticks[49].encoder_counts[0];
    const Both after = digests(ticks, *sample::table(1));
    CHECK(after.io != before.io);
    CHECK(after.state != before.state);
}

TEST_CASE("motor words, buttons and homed are io; the rest is state alone; clocks are neither") {
    const Both before = digests(sample::ticks(5), *sample::table(1));
    const auto changed = [&](auto change) {
        auto ticks = sample::ticks(5);
        change(ticks[2]);
        const Both after = digests(ticks, *sample::table(1));
        return (after.io != before.io ? 1 : 0) + (after.state != before.state ? 2 : 0);
    };
    CHECK(changed([](pal_tick& t) { --t.motor_counts[1]; }) == 3);
    CHECK(changed([](pal_tick& t) { t.buttons = 1; }) == 3);
    CHECK(changed([](pal_tick& t) { t.homed ^= 1; }) == 3);
    CHECK(changed([](pal_tick& t) { t.potential_j = 1e-30F; }) == 2);
    CHECK(changed([](pal_tick& t) { t.truth_force_n[2] = -0.0F; }) == 2);
    CHECK(changed([](pal_tick& t) { t.path_tick += 1; }) == 2);
    CHECK(changed([](pal_tick& t) { t.t_ns += 1; }) == 0);
    CHECK(changed([](pal_tick& t) { t.stamp_ns[5] = 9; }) == 0);
    CHECK(changed([](pal_tick& t) { t.wake_late_ns = 9; }) == 0);
}

TEST_CASE("any used byte of a table changes the state digest, bytes behind it do not") {
    const Both before = digests({}, *sample::table(1));
    const auto table = sample::table(1);
    for (std::uint32_t i = 16; i < table->n_bytes; ++i) {
        const auto other = sample::table(1);
        reinterpret_cast<unsigned char*>(other.get())[i] ^= 1U;
        if (!pal_table_header_ok(other.get())) continue;
        INFO(i);
        const Both after = digests({}, *other);
        CHECK(after.state != before.state);
        CHECK(after.io == before.io);
    }
    table->coef[PAL_TABLE_COEFS_MAX - 1] = 1.0F;
    CHECK(digests({}, *table).state == before.state);
}
