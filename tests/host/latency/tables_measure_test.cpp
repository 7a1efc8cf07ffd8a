#include <catch2/catch.hpp>

#include "host/latency/measure.hpp"
#include "host/latency/publications.hpp"
#include "tests/host/latency/run.hpp"

using namespace palpate::latency;
using Catch::Matchers::Contains;

namespace {

/// Table 1 from tick 10 on, table 2 from tick 20 on, table 4 from tick 30 on; motors move two ticks after.
std::vector<pal_tick> run_with_tables() {
    auto ticks = sample::run(40);
    for (std::size_t i = 10; i < 40; ++i) {
        ticks[i].table_id = i < 20 ? 1 : i < 30 ? 2 : 4;
        ticks[i].motor_counts[1] = static_cast<std::int16_t>(i < 12   ? 0
                                                             : i < 22 ? -100
                                                             : i < 32 ? -200
                                                                      : -300);
    }
    return ticks;
}

/// Published 300 us, 700 us and 4.2 ms before the tick of first use; made for ticks 3, 15 and 21.
Publications published() {
    return {{1, {.t_ns = sample::T0_NS + 10000000 - 300000, .made_for_tick = 3}},
            {2, {.t_ns = sample::T0_NS + 20000000 - 700000, .made_for_tick = 15, .marked = true}},
            {3, {.t_ns = sample::T0_NS + 25000000, .made_for_tick = 18}},
            {4, {.t_ns = sample::T0_NS + 30000000 - 4200000, .made_for_tick = 21}}};
}

}  // namespace

TEST_CASE("publish-to-use runs from the publication to the first force from the table") {
    const Measured m = measure(run_with_tables(), published());
    CHECK(m.publish_to_use.histogram.n() == 3);  // table 3 was never used
    // T3 is 10 us (late) + 20 us after the programmed start.
    CHECK(m.publish_to_use.histogram.min_ns() == 330000);
    CHECK(m.publish_to_use.histogram.max_ns() == 4230000);
    CHECK(m.publish_to_use.histogram.mean_ns() == Approx((330000.0 + 730000.0 + 4230000.0) / 3));
}

TEST_CASE("publish-to-motor is measured on marked tables, to the first other motor words") {
    const Measured m = measure(run_with_tables(), published());
    CHECK(m.publish_to_motor.histogram.n() == 1);
    CHECK(m.publish_to_motor.histogram.max_ns() == 700000 + 2 * 1000000 + 33000);  // T4 of tick 22
    Publications unmarked = published();
    unmarked[2].marked = false;
    CHECK_THAT(measure(run_with_tables(), unmarked).publish_to_motor.why_unknown,
               Contains("no marked table"));
}

TEST_CASE("a marked table that moves no motor is not known, not fast") {
    auto ticks = run_with_tables();
    for (pal_tick& tick : ticks) tick.motor_counts[1] = 7;
    const Measured m = measure(ticks, published());
    CHECK_FALSE(m.publish_to_motor.known());
    CHECK(m.publish_to_motor.n_unknown == 1);
    CHECK_THAT(m.publish_to_motor.why_unknown, Contains("moved the motors"));
}

TEST_CASE("the age of a table is counted from the tick that it was made for, on every tick") {
    const Measured m = measure(run_with_tables(), published());
    CHECK(m.table_age.histogram.n() == 30);
    CHECK(m.table_age.histogram.min_ns() == 5000000);   // tick 20, made for 15
    CHECK(m.table_age.histogram.max_ns() == 18000000);  // tick 39, made for 21
    // 7..16, 5..14 and 9..18 ms
    CHECK(m.table_age.histogram.mean_ns() == Approx(11.5e6));
}

TEST_CASE("a missed period makes a table older") {
    auto ticks = run_with_tables();
    for (std::size_t i = 25; i < 40; ++i) sample::shift(ticks[i], 10000000);
    CHECK(measure(ticks, published()).table_age.histogram.max_ns() == 28000000);
}

TEST_CASE("what is not known of a table is counted, and named when it is not known of any") {
    const auto ticks = run_with_tables();
    SECTION("nothing was published") {
        const Measured m = measure(ticks, {});
        CHECK_THAT(m.publish_to_use.why_unknown, Contains("times of publication"));
        CHECK_THAT(m.table_age.why_unknown, Contains("made for are not known"));
        CHECK(m.publish_to_use.n_unknown == 3);
        CHECK(m.table_age.n_unknown == 30);
    }
    SECTION("a publication after its use is no negative time") {
        Publications late = published();
        late[1].t_ns += 1000000;
        const Measured m = measure(ticks, late);
        CHECK(m.publish_to_use.histogram.n() == 2);
        CHECK(m.publish_to_use.n_unknown == 1);
    }
    SECTION("a table that was in use before the first record has no first use") {
        const std::vector<pal_tick> later(ticks.begin() + 15, ticks.end());
        const Measured m = measure(later, published());
        CHECK(m.publish_to_use.histogram.n() == 2);
        CHECK(m.publish_to_use.n_unknown == 1);
        CHECK(m.table_age.n_unknown == 5);  // ticks 15 to 19: tick 3 is not in the record
    }
    SECTION("no table was used") {
        const Measured m = measure(sample::run(5), published());
        CHECK_THAT(m.publish_to_use.why_unknown, Contains("no table was used"));
        CHECK_THAT(m.publish_to_motor.why_unknown, Contains("no table was used"));
        CHECK_THAT(m.table_age.why_unknown, Contains("no table was used"));
    }
}

TEST_CASE("a record tells the tick of each table, and the publication where its header has it") {
    pal_table table{};
    table.id = 9;
    table.n_nodes = 5;
    table.tick = 1234;
    pal_table_seal(&table);
    palpate::record::Record record;
    record.header = nlohmann::json::object();
    record.tables[9] = palpate::record::table_bytes(table);
    CHECK(publications_of(record).at(9).made_for_tick == 1234U);
    CHECK(publications_of(record).at(9).t_ns == 0);
    record.header["published_ns"] = {{9, 5000000001}};
    CHECK(publications_of(record).at(9).t_ns == 5000000001);
    CHECK(publications_of(record).at(9).made_for_tick == 1234U);
    for (const char* bad : {"7", "[7]", "[[1]]", "[[1, -2]]", "[[1, \"2\"]]"}) {
        CAPTURE(bad);
        record.header["published_ns"] = nlohmann::json::parse(bad);
        CHECK_THROWS_AS(publications_of(record), palpate::record::Error);
    }
}
