// Which ticks are checked, and that each part of the error answers to what it is named after.
#include <catch2/catch.hpp>
#include <functional>

#include "host/app/run.hpp"
#include "host/report/figures.hpp"
#include "tests/host/app/sheet.hpp"

using namespace palpate;
using namespace palpate::test;

namespace {

std::vector<report::Touch> touches_with(std::size_t n_contact) {
    const contact::Foot foot{Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), 0.0, 0.0, 0};
    std::vector<report::Touch> touches(n_contact + 10);
    for (std::size_t i = 5; i < 5 + n_contact; ++i) touches[i] = {.foot = foot, .depth_m = 1e-3};
    return touches;
}

struct Felt {
    std::vector<pal_tick> ticks;
    report::ForceError error;
    report::Json figures;
};

/// The 2 s sheet: pressed in half a second, stroked, left.
Felt feel(
    const std::vector<std::string>& set, std::size_t n_wanted = report::SAMPLE / 4,
    const std::function<void(pal_table&)>& change = [](pal_table&) {}) {
    app::Progress quiet(true);
    const app::Prepared prepared = app::prepare(scene::build(sheet_scene(PAL_TEST_FOLDER, set)), quiet);
    const app::RunResult run = app::run_virtual(prepared, {}, quiet, change);
    const auto touches = report::touches(*prepared.world, run.ticks);
    const auto error = report::force_error(*prepared.world, run.ticks, touches, run.tables,
                                           app::loop_model(prepared), n_wanted, [](double) {});
    REQUIRE(error);
    CHECK(error->n_without_reference == 0);
    return {run.ticks, *error, report::run_figures(*prepared.world, run.ticks, touches)};
}

/// The scene as it is, felt once for all comparisons.
const Felt& plain() {
    static const Felt felt = feel({}, report::SAMPLE);
    return felt;
}

}  // namespace

TEST_CASE("every n-th contact tick is checked, n = contact ticks / 400 rounded down, or every one") {
    const auto n_checked = [](std::size_t n_contact, std::size_t n_wanted) {
        return report::ticks_to_check(touches_with(n_contact), n_wanted).size();
    };
    CHECK(n_checked(0, report::SAMPLE) == 0);
    CHECK(n_checked(399, report::SAMPLE) == 399);
    CHECK(n_checked(400, report::SAMPLE) == 400);
    CHECK(n_checked(799, report::SAMPLE) == 799);
    CHECK(n_checked(800, report::SAMPLE) == 400);
    CHECK(n_checked(8737, report::SAMPLE) == 417);  // every 21st
    CHECK(n_checked(8737, report::EVERY_TICK) == 8737);
    CHECK(report::ticks_to_check(touches_with(800), report::SAMPLE)[1] == 7);
}

TEST_CASE("in full each tick of contact is compared, and the sample says the same") {
    const Felt &sample = plain(), full = feel({}, report::EVERY_TICK);
    CHECK(full.error.n_checked == full.error.n_contact);
    CHECK(sample.error.n_contact == full.error.n_contact);
    CHECK(full.error.n_contact > 1400);
    CHECK(sample.error.n_checked < full.error.n_contact / 2);
    CHECK(full.error.total.rms_relative < 0.03);
    CHECK(sample.error.total.rms_relative == Approx(full.error.total.rms_relative).epsilon(0.1));
    CHECK(full.figures["n_contact_ticks"] == full.error.n_contact);
    CHECK(full.error.n_fading > 0);
    CHECK(full.error.n_clamped + full.error.n_ramped + full.error.n_stale + full.error.n_without_table == 0);
}

TEST_CASE("wrong tables raise the part of staleness: a fresh one would be right") {
    const Felt &right = plain(), wrong = feel({}, report::SAMPLE / 4, [](pal_table&table) {
                                     const std::size_t plane = (table.n_nodes + 2U) * (table.n_nodes + 2U);
                                     for (std::size_t i = plane; i < 2 * plane; ++i) table.coef[i] *= 1.05F;
                                 });
    CHECK(wrong.error.staleness.rms_relative == Approx(0.05).epsilon(0.2));
    CHECK(right.error.staleness.rms_relative < 0.01);
    CHECK(wrong.error.table.rms_relative < 0.01);
}

TEST_CASE("clamped ticks are counted and their missing force is in the error") {
    const Felt clamped = feel({"touch.force_max_n=0.5"});
    CHECK(clamped.error.n_clamped > clamped.error.n_checked / 2);
    CHECK(clamped.error.staleness.rms_relative > 0.3);
    CHECK(clamped.error.total.rms_relative > 0.3);
    CHECK(clamped.error.table.rms_relative < 0.01);
}

TEST_CASE("a faster hand raises the part of delay in proportion") {
    const std::vector<std::string> fast{
        "hand.path=[{ t_s = 0.0, at_m = [-0.003, 0.0, 0.0], depth_m = -0.004 }, "
        "{ t_s = 0.05, at_m = [-0.003, 0.0, 0.0], depth_m = 0.004 }, "
        "{ t_s = 0.15, at_m = [0.003, 0.0, 0.0], depth_m = 0.004 }, "
        "{ t_s = 0.20, at_m = [0.003, 0.0, 0.0], depth_m = -0.004 }]"};
    CHECK(feel(fast).error.delay.rms_relative > 4.0 * plain().error.delay.rms_relative);
}

TEST_CASE("contact without a table is contact: late tables are counted and make the error") {
    const Felt late = feel({"solver.delay_ticks=700"});
    CHECK(late.error.n_contact > 1400);
    CHECK(late.error.n_without_table > late.error.n_checked / 4);
    CHECK(late.error.total.rms_relative > 0.3);
}

TEST_CASE("what the listener to progress throws ends the check") {
    struct Enough {};
    app::Progress quiet(true);
    const app::Prepared prepared = app::prepare(scene::build(sheet_scene(PAL_TEST_FOLDER)), quiet);
    const app::RunResult run = app::run_virtual(prepared, {}, quiet);
    const auto touches = report::touches(*prepared.world, run.ticks);
    CHECK_THROWS_AS(
        report::force_error(*prepared.world, run.ticks, touches, run.tables, app::loop_model(prepared),
                            report::EVERY_TICK, [](double) { throw Enough{}; }),
        Enough);
}
