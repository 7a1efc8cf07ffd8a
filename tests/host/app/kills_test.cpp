// Each side of a run in real time is killed at random moments of a press, many times over. 20 kills; 1000
// with PALPATE_SOAK.
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <random>

#include "host/record/record.hpp"
#include "tests/host/app/pressing.hpp"

using namespace palpate;
using namespace palpate::test;

namespace {

constexpr unsigned SEED = 20261128;
constexpr int KILLS_IN_A_RUN = 8;  // of its table builder

int n_kills() {
    return std::getenv("PALPATE_SOAK") != nullptr ? 1000 : 20;
}

/// Somewhere in the next 0.4 s: in the middle of anything.
void wait_for_any_moment(std::mt19937& random) {
    usleep(std::uniform_int_distribution<useconds_t>(0, 400000)(random));
}

/// The table builder's next life, and that the loop uses a table of it.
void kill_the_builder(Pressing& run, std::mt19937& random) {
    wait_for_any_moment(random);
    const pid_t victim = child_of(run.palpate->pid(), "palpate-tables");
    REQUIRE(victim > 0);
    kill(victim, SIGKILL);
    pid_t next = 0;
    while (next == 0 || next == victim) {
        look_again();
        REQUIRE(run.palpate->running());
        next = child_of(run.palpate->pid(), "palpate-tables");
    }
}

/// Ends the run and reads what became of its builders; the longest time from a death to the next table, s.
double check_builders(Pressing& run, int n_killed) {
    run.palpate->send(SIGINT);
    REQUIRE(run.palpate->wait() == 130);
    const nlohmann::json summary = run.summary();
    CHECK(motors_at_rest(summary["device"]));
    CHECK(summary["supervision"]["n_records_lost"] == 0);
    const nlohmann::json& restarts = summary["supervision"]["table_builder_restarts"];
    REQUIRE(restarts.size() == static_cast<std::size_t>(n_killed));
    double longest_s = 0.0;
    for (const nlohmann::json& restart : restarts) {
        CHECK(restart["why"] == "signal 9");
        if (restart["table_after_s"].is_number())
            longest_s = std::max(longest_s, restart["table_after_s"].get<double>());
    }
    const record::Record kept = record::read(run.folder / "result" / "run.palrec");
    std::uint64_t newest = 0;
    for (const pal_tick& tick : kept.ticks) {
        CHECK((tick.faults & PAL_FAULT_TABLE_BAD) == 0);
        if (tick.table_id < newest && tick.table_id != 0) FAIL_CHECK("a table's id went back");
        newest = std::max(newest, tick.table_id);
    }
    CHECK(newest >> 32U > 0);  // the loop used a later builder's tables
    run.check_nothing_is_left();
    return longest_s;
}

void kill_the_loop(std::mt19937& random) {
    Pressing run;
    wait_for_any_moment(random);
    kill(run.loop, SIGKILL);
    CHECK(run.palpate->wait() == 3);
    const nlohmann::json summary = run.summary();
    INFO(summary["device"] << summary["supervision"]);
    CHECK(summary["supervision"]["take_over"]["done"] == true);
    CHECK(motors_at_rest(summary["device"]));
    run.check_nothing_is_left();
}

void kill_palpate(std::mt19937& random) {
    Pressing run;
    wait_for_any_moment(random);
    const nlohmann::json status = run.kill_palpate();
    INFO(status);
    CHECK(motors_at_rest(status));
    kill(run.device, SIGTERM);  // it would linger for 5 s, to be asked
    CHECK(wait_for_orphan(run.device) == 0);
    CHECK(no_children());
    CHECK(segments_of(run.palpate->pid()).size() ==
          1);  // the next run keeps its flight record and removes it
}

}  // namespace

TEST_CASE("whoever is killed, at whatever moment: motors at rest, nothing torn, stuck or left", "[kills]") {
    INFO("seed " << SEED);
    std::mt19937 random(SEED);
    const int n = n_kills();
    double longest_s = 0.0;
    int n_builders = 0;
    pid_t last = 0;
    for (int i = 0; i < n;) {
        Pressing run;
        const int n_here = std::min(KILLS_IN_A_RUN, n - i);
        for (int k = 0; k < n_here; ++k) kill_the_builder(run, random);
        longest_s = std::max(longest_s, check_builders(run, n_here));
        n_builders += n_here;
        i += n_here;
        for (int k = 0; k < KILLS_IN_A_RUN / 2 && i < n; ++k, ++i) kill_the_loop(random);
        for (int k = 0; k < KILLS_IN_A_RUN / 2 && i < n; ++k, ++i) kill_palpate(random);
        last = run.palpate->pid();
    }
    CHECK(segments_of(last).empty());
    std::cout << n << " kills, " << n_builders << " of table builders; the next one's first table after "
              << longest_s << " s at most\n";
}
