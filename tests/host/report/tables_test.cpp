// From the scene to the loop: tables of every size arrive, refused ones have a name, late ones are late.
#include <catch2/catch.hpp>

#include "host/app/run.hpp"
#include "host/report/figures.hpp"
#include "tests/host/app/sheet.hpp"

using namespace palpate;
using namespace palpate::test;

namespace {

constexpr std::size_t QUARTER = report::SAMPLE / 4;  // of the ticks, for the bounds here

struct Felt {
    app::Prepared prepared;
    app::RunResult run;
    std::vector<report::Touch> touches;
    report::Json figures;

    [[nodiscard]] std::optional<report::ForceError> error() const {
        return report::force_error(*prepared.world, run.ticks, touches, run.tables, app::loop_model(prepared),
                                   QUARTER, [](double) {});
    }
    [[nodiscard]] std::size_t n_with(std::uint32_t faults) const {
        std::size_t n = 0;
        for (const pal_tick& tick : run.ticks) n += (tick.faults & faults) != 0 ? 1 : 0;
        return n;
    }
};

Felt feel(const std::vector<std::string>& set) {
    app::Progress quiet(true);
    Felt felt{app::prepare(scene::build(sheet_scene(PAL_TEST_FOLDER, set)), quiet), {}, {}, {}};
    felt.run = app::run_virtual(felt.prepared, {}, quiet);
    felt.touches = report::touches(*felt.prepared.world, felt.run.ticks);
    felt.figures = report::run_figures(*felt.prepared.world, felt.run.ticks, felt.touches);
    return felt;
}

/// Pressed in half a second, held for two, left.
const char* const RESTING =
    "hand.path=[{ t_s = 0.0, at_m = [0.0, 0.0, 0.0], depth_m = -0.004 }, "
    "{ t_s = 0.5, at_m = [0.0, 0.0, 0.0], depth_m = 0.003 }, "
    "{ t_s = 2.5, at_m = [0.0, 0.0, 0.0], depth_m = 0.003 }, "
    "{ t_s = 3.0, at_m = [0.0, 0.0, 0.0], depth_m = -0.004 }]";

}  // namespace

TEST_CASE("tables of every node count reach the loop, are used, and give the right force") {
    const int n = GENERATE(as<int>{}, 5, 17, 33, 65);
    CAPTURE(n);
    const Felt felt = feel({"solver.table_nodes=" + std::to_string(n)});
    CHECK(felt.n_with(PAL_FAULT_TABLE_BAD) == 0);
    CHECK(felt.n_with(PAL_FAULT_TABLE_LEFT) == 0);
    CHECK(felt.run.n_tables_refused == 0);
    CHECK(felt.run.failure.empty());
    CHECK(felt.run.no_tables.empty());
    const auto error = felt.error();
    REQUIRE(error);
    CHECK(error->n_without_reference == 0);
    CHECK(error->n_without_table == 0);
    CHECK(error->total.rms_relative < 0.03);
}

TEST_CASE("a fine tolerance is met to the end, the comparison with fresh tables too") {
    const Felt felt = feel({"solver.tolerance=1e-5"});
    const auto error = felt.error();
    REQUIRE(error);
    CHECK(error->total.rms_relative < 0.03);
    CHECK(error->table.rms_relative < 0.01);
}

TEST_CASE("where the loop accepts no table the run has failed, and says why") {
    const Felt felt = feel({"skin.young_pa=1e9"});
    CHECK(felt.n_with(PAL_FAULT_TABLE_BAD) == 0);  // none was even sent
    CHECK(felt.run.tables.empty());
    CHECK_THAT(felt.run.no_tables, Catch::Matchers::Contains("every table was refused: stiffness ") &&
                                       Catch::Matchers::Contains("above what the loop accepts (6.0 kN/m)"));
}

TEST_CASE("where no patch can be cut anywhere the run has failed, and says why") {
    const Felt felt = feel({"patch.size_m=0.001"});
    CHECK(felt.run.tables.empty());
    CHECK_THAT(felt.run.no_tables, Catch::Matchers::Contains("no table could be built: "));
}

TEST_CASE("a table that comes 200 ms late is stale until it is there") {
    const Felt felt = feel({"solver.delay_ticks=200"});
    CHECK(felt.figures["n_stale_ticks"] > 100);
    CHECK(felt.n_with(PAL_FAULT_TABLE_DROPPED) == 0);
    CHECK(feel({"solver.delay_ticks=600"}).n_with(PAL_FAULT_TABLE_DROPPED) > 50);
}

TEST_CASE("a build of 60 ms is no fault") {
    CHECK(feel({"solver.delay_ticks=60"}).figures["n_stale_ticks"] == 0);
}

TEST_CASE("a hand that rests has fresh tables, however long one takes") {
    const int delay = GENERATE(as<int>{}, 8, 200);
    const Felt felt = feel({RESTING, "solver.delay_ticks=" + std::to_string(delay)});
    std::size_t n_resting = 0;
    for (const pal_tick& tick : felt.run.ticks) {
        if (tick.path_tick < 1200 || tick.path_tick > 2400) continue;
        ++n_resting;
        if ((tick.faults & (PAL_FAULT_TABLE_STALE | PAL_FAULT_TABLE_DROPPED)) != 0) FAIL(tick.tick);
    }
    CHECK(n_resting > 1000);
}
