// The rungs of the safety ladder (docs/DESIGN.md 7) in real time: a process of a run is stopped for a while,
// or all processors are taken away; then it goes on, and the record tells what the forces were meanwhile.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <memory>

#include "host/record/record.hpp"
#include "tests/host/app/pressing.hpp"

using namespace palpate;
using namespace palpate::test;
using Catch::Matchers::Contains;

namespace {

bool no_force(const pal_tick& tick) {
    bool none = true;
    for (int i = 0; i < 3; ++i) none = none && tick.motor_counts[i] == 0 && tick.force_n[i] == 0.0F;
    return none;
}

/// Stops `process` for at least that long, then lets it go on.
void stop_for(pid_t process, useconds_t us) {
    kill(process, SIGSTOP);
    usleep(us);
    kill(process, SIGCONT);
}

/// Until the run has gone on for another second of its path, however often it was stopped on the way.
void let_it_go_on(Pressing& run) {
    const int from = device_status(run.folder)["path_tick"];
    while (device_status(run.folder)["path_tick"] < from + 1000) {
        look_again();
        REQUIRE(run.palpate->running());
    }
}

struct Ended {
    record::Record record;
    nlohmann::json summary;
    std::uint32_t faults = 0;  ///< of all ticks
};

/// Ends the run; what holds of every run is checked here: a latched stop is no force, and no force is above
/// its limit.
Ended end(Pressing& run) {
    run.palpate->send(SIGINT);
    REQUIRE(run.palpate->wait() == 130);
    Ended ended{record::read(run.folder / "result" / "run.palrec"), run.summary()};
    std::size_t n_unsafe = 0;
    for (const pal_tick& tick : ended.record.ticks) {
        ended.faults |= tick.faults;
        const float force_n = std::hypot(tick.force_n[0], tick.force_n[1], tick.force_n[2]);
        if (!(force_n <= 8.0F) || (tick.stop != 0 && !no_force(tick))) ++n_unsafe;
    }
    CHECK(n_unsafe == 0);
    CHECK(motors_at_rest(ended.summary["device"]));
    run.check_nothing_is_left();
    return ended;
}

/// A stop by this bit was latched, counted and recorded.
void check_stop(const Pressing& run, const Ended& ended, const std::string& word) {
    INFO(ended.summary["stop_counts"] << ended.summary["supervision"]);
    CHECK(ended.summary["stop_counts"][word] > 0);
    const record::Record flight = record::read(run.folder / "result" / "flight-1.palrec");
    CHECK(flight.header["flight"]["reason"] == "stop: " + word);
    REQUIRE_FALSE(flight.ticks.empty());
    CHECK(flight.ticks.back().stop != 0);
    CHECK_THAT(text_of(run.folder / "result" / "events.csv"), Contains("," + word));
}

}  // namespace

TEST_CASE("a loop that is stopped for 60 ms comes back with its stop latched, counted and recorded",
          "[rungs]") {
    Pressing run;
    stop_for(run.loop, 60000);
    let_it_go_on(run);
    while (motors_at_rest(device_status(run.folder))) {  // a simulated device is released by itself
        look_again();
        REQUIRE(run.palpate->running());
    }
    const Ended ended = end(run);
    check_stop(run, ended, "device-lost");
    CHECK(ended.summary["n_missed_ticks"] >= 20);
}

TEST_CASE("a device that is silent for 60 ms is a stop with a name", "[rungs]") {
    Pressing run;
    stop_for(run.device, 60000);
    let_it_go_on(run);
    const Ended ended = end(run);
    check_stop(run, ended, "device-lost");
    CHECK((ended.faults & PAL_FAULT_LATE) != 0);
}

TEST_CASE("a table builder that is stopped leaves its table to grow stale, then to be dropped to no force",
          "[rungs]") {
    Pressing run;
    stop_for(run.builder, 900000);
    let_it_go_on(run);
    const Ended ended = end(run);
    CHECK((ended.faults & PAL_FAULT_TABLE_STALE) != 0);
    CHECK((ended.faults & PAL_FAULT_TABLE_DROPPED) != 0);
    std::size_t n_dropped = 0, n_pushing = 0;
    for (const pal_tick& tick : ended.record.ticks) {
        if (tick.table_id == 0 || tick.table_age_ticks < 550) continue;
        ++n_dropped;
        n_pushing += static_cast<std::size_t>(!no_force(tick));
    }
    CHECK(n_dropped > 0);
    CHECK(n_pushing == 0);
    CHECK(ended.summary["fault_ticks"]["table-dropped"] >= n_dropped);
    CHECK(ended.summary["supervision"]["table_builder_restarts"].empty());  // it was slow, not dead
}

TEST_CASE("a table builder without a sign of life is killed and replaced", "[rungs]") {
    Pressing run;
    kill(run.builder, SIGSTOP);
    pid_t next = run.builder;
    while (next == run.builder || next == 0) {
        look_again();
        REQUIRE(run.palpate->running());
        next = child_of(run.palpate->pid(), "palpate-tables");
    }
    let_it_go_on(run);
    const Ended ended = end(run);
    const nlohmann::json& restarts = ended.summary["supervision"]["table_builder_restarts"];
    REQUIRE(restarts.size() == 1);
    CHECK(restarts[0]["why"] == "no sign of life for 3 s");
}

TEST_CASE("with every processor taken away the forces stay safe and the run goes on", "[rungs]") {
    Pressing run;
    {
        std::vector<std::unique_ptr<Program>> hogs;
        for (int i = 0; i < 6; ++i) {
            hogs.push_back(std::make_unique<Program>(
                "/bin/sh", std::vector<std::string>{"-c", "while :; do :; done"}, run.folder));
        }
        let_it_go_on(run);
    }
    const Ended ended = end(run);
    CHECK(ended.summary["failure"] == "");
}
