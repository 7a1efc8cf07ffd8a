// The virtual run repeats to the bit, and its digests tell the smallest changes apart.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>

#include "host/app/run.hpp"
#include "host/cloud/cloud.hpp"
#include "tests/host/app/processes.hpp"
#include "tests/host/app/sheet.hpp"

using namespace palpate;
using namespace palpate::test;

namespace {

constexpr int ALL_HOMED = 7;

app::Prepared prepared(const std::vector<std::string>& set = {}) {
    const Folder folder;
    app::Progress quiet(true);
    return app::prepare(scene::build(sheet_scene(folder.path(), set)), quiet);
}

app::RunResult run(const app::Prepared& prepared) {
    app::Progress quiet(true);
    return app::run_virtual(prepared, {}, quiet);
}

std::string digest_io_of(const std::vector<pal_tick>& ticks) {
    record::Digest digest;
    for (const pal_tick& tick : ticks) digest.tick(tick);
    return digest.io();
}

/// The sheet with a spot in its corner, far from everything that is touched, that holds one point.
app::Prepared with_corner_times(const std::string& factor) {
    return prepared({"skin.young_pa=0.3e6",
                     "change=[{ shape = \"nodule\", at_m = [0.02, 0.02, 0.0], radius_m = 0.0002, edge_m = "
                     "0.0001, factor = " +
                         factor + " }]"});
}

}  // namespace

TEST_CASE("a virtual run is the same twice, from reading the scene to the last tick", "[digest]") {
    const app::RunResult a = run(prepared()), b = run(prepared());
    CHECK(a.digest_io == b.digest_io);
    CHECK(a.digest_state == b.digest_state);
    REQUIRE(a.ticks.size() == b.ticks.size());
    CHECK(std::memcmp(a.ticks.data(), b.ticks.data(), a.ticks.size() * sizeof(pal_tick)) == 0);
    CHECK(a.tables == b.tables);
    bool pressed = false;
    for (const pal_tick& tick : a.ticks) pressed = pressed || tick.motor_counts[0] != 0;
    CHECK(pressed);
}

TEST_CASE("another seed changes what the counters read before homing, and nothing else", "[digest]") {
    app::RunResult a = run(prepared()), b = run(prepared({"run.seed=2"}));
    CHECK(a.digest_io != b.digest_io);
    REQUIRE(a.ticks.size() == b.ticks.size());
    for (std::size_t i = 0; i < a.ticks.size(); ++i) {
        if (a.ticks[i].homed != ALL_HOMED) {
            CHECK(std::memcmp(a.ticks[i].encoder_counts, b.ticks[i].encoder_counts,
                              sizeof a.ticks[i].encoder_counts) != 0);
            std::memcpy(b.ticks[i].encoder_counts, a.ticks[i].encoder_counts,
                        sizeof a.ticks[i].encoder_counts);
        }
    }
    CHECK(std::memcmp(a.ticks.data(), b.ticks.data(), a.ticks.size() * sizeof(pal_tick)) == 0);
    CHECK(a.tables == b.tables);
}

TEST_CASE("one encoder count of one tick changes digest_io", "[digest]") {
    const app::RunResult result = run(prepared());
    REQUIRE(digest_io_of(result.ticks) == result.digest_io);
    for (const std::size_t at : {std::size_t{0}, result.ticks.size() / 2, result.ticks.size() - 1}) {
        for (const std::size_t axis : {std::size_t{0}, std::size_t{1}, std::size_t{2}}) {
            std::vector<pal_tick> changed = result.ticks;
            changed[at].encoder_counts[axis] =
                static_cast<std::int16_t>(changed[at].encoder_counts[axis] ^ 1);
            CHECK(digest_io_of(changed) != result.digest_io);
        }
    }
}

TEST_CASE("one ulp in one point's E changes digest_state, even where nobody feels it", "[digest]") {
    const app::Prepared plain = with_corner_times("1.0"), changed = with_corner_times("1.0000000000000002");
    const std::vector<double>&a = plain.world->cloud.young_pa, &b = changed.world->cloud.young_pa;
    REQUIRE(a.size() == b.size());
    std::size_t n_different = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (a[i] == b[i]) continue;
        ++n_different;
        CHECK(b[i] == std::nextafter(a[i], std::numeric_limits<double>::infinity()));
    }
    REQUIRE(n_different == 1);
    const app::RunResult ran_plain = run(plain), ran_changed = run(changed);
    CHECK(ran_plain.digest_io == ran_changed.digest_io);
    CHECK(ran_plain.digest_state != ran_changed.digest_state);
    CHECK(ran_plain.digest_state == run(with_corner_times("1.0")).digest_state);
}
