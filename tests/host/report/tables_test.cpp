// From the scene to the loop: tables of every size arrive, refused ones have a name, late ones are late.
#include <catch2/catch.hpp>
#include <future>

#include "host/app/run.hpp"
#include "host/app/table_thread.hpp"
#include "host/report/figures.hpp"
#include "tests/fuzz/good_table.hpp"
#include "tests/host/app/sheet.hpp"

using namespace palpate;
using namespace palpate::test;

namespace {

struct Felt {
    app::Prepared prepared;
    app::RunResult run;
    std::vector<report::Touch> touches;
    report::Json figures;

    [[nodiscard]] std::optional<report::ForceError> error() const {
        return report::force_error(*prepared.world, run.ticks, touches, run.tables, app::loop_model(prepared),
                                   false, [](double) {});
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

namespace {

/// A table thread whose builder hands out one table, then works for as long as the test wants.
struct Slow {
    std::unique_ptr<pal_link> link = std::make_unique<pal_link>();
    std::promise<void> at_work, may_end;
    int n_updates = 0;
    app::TableThread thread;

    Slow() : thread([this](const pal_tick&) { return update(); }, init()) {}

    pal_link& init() {
        pal_link_init(link.get(), 1);
        return *link;
    }
    std::unique_ptr<pal_table> update() {
        auto table = std::make_unique<pal_table>();
        fuzz::fill_good(*table, 5, 0);
        if (n_updates++ == 0) return table;
        at_work.set_value();
        may_end.get_future().wait();
        throw std::runtime_error("the plate broke");
    }
    void offer(std::uint32_t tick) {
        pal_tick record{};
        record.tick = tick;
        thread.offer(record);
    }
    /// Ticks one by one from `first` to before `end`; the ticks at which a table came.
    std::vector<std::uint32_t> came(std::uint32_t first, std::uint32_t end) {
        std::vector<std::uint32_t> ticks;
        for (std::uint32_t tick = first; tick < end; ++tick) {
            offer(tick);
            if (pal_table_ring_take(&link->tables)) ticks.push_back(tick);
        }
        return ticks;
    }
};

}  // namespace

TEST_CASE("in real time the last table is kept fresh for a short build, and not for one that hangs") {
    Slow slow;
    slow.offer(100);
    while (!pal_table_ring_take(&slow.link->tables)) std::this_thread::yield();
    slow.offer(130);
    slow.at_work.get_future().wait();
    CHECK(slow.came(131, 1000) == std::vector<std::uint32_t>{140});  // at 180 the build is 50 ticks old
    slow.may_end.set_value();
    slow.thread.stop();
    CHECK(slow.came(1000, 1200).empty());
    REQUIRE(slow.thread.failure());
    CHECK_THROWS_WITH(std::rethrow_exception(slow.thread.failure()), "the plate broke");
    CHECK(slow.thread.tables().size() == 2);
}
