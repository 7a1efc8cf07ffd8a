#include <catch2/catch.hpp>

#include "tests/host/record/sample.hpp"

using namespace palpate;

TEST_CASE("events.csv tells states, tables, faults, stops, contact and missed periods") {
    std::vector<pal_tick> ticks(8);
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        ticks[i] = {};
        ticks[i].tick = static_cast<std::uint32_t>(i);
        ticks[i].path_tick = i < 2 ? 0 : static_cast<std::uint32_t>(i - 1);
        ticks[i].state = i < 2 ? PAL_STATE_HOMING : PAL_STATE_ENABLED;
        ticks[i].table_id = i < 3 ? 0 : i < 6 ? 1 : 2;
        ticks[i].depth_m = i >= 4 && i <= 6 ? 0.5F : -1.0F;
        ticks[i].faults = i == 0   ? PAL_FAULT_TABLE_MISSING
                          : i == 5 ? PAL_FAULT_FORCE_CLAMP | PAL_FAULT_LATE
                                   : 0;
        ticks[i].n_missed = i < 6 ? 0 : 3;
    }
    ticks[7].state = PAL_STATE_FAULT;
    ticks[7].stop = PAL_FAULT_ESTOP;
    const auto folder = sample::folder("events");
    record::write_events_csv(folder / "events.csv", ticks);
    CHECK(sample::text_in(folder / "events.csv") ==
          "t_s,tick,event,detail\n"
          "-0.001,0,state,homing\n"
          "-0.001,0,fault-begin,table-missing\n"
          "0,1,fault-end,table-missing\n"
          "0.001,2,state,enabled\n"
          "0.002,3,table,1\n"
          "0.003,4,first-contact,depth_m 0.5\n"
          "0.004,5,fault-begin,force-clamp\n"
          "0.004,5,fault-begin,late\n"
          "0.005,6,fault-end,force-clamp\n"
          "0.005,6,fault-end,late\n"
          "0.005,6,table,2\n"
          "0.005,6,missed,3\n"
          "0.005,6,last-contact,depth_m 0.5\n"
          "0.006,7,state,fault\n"
          "0.006,7,stop,e-stop\n");
}

TEST_CASE("a run without ticks has no events") {
    const auto folder = sample::folder("no_events");
    record::write_events_csv(folder / "events.csv", {});
    CHECK(sample::text_in(folder / "events.csv") == "t_s,tick,event,detail\n");
}

TEST_CASE("every fault, state and stop has its word") {
    CHECK(record::fault_words(0) == "none");
    CHECK(record::fault_words(PAL_FAULT_NOT_FINITE) == "not-finite");
    CHECK(record::fault_words(PAL_FAULT_WORKSPACE) == "workspace");
    CHECK(record::fault_words(PAL_FAULT_TABLE_MISSING) == "table-missing");
    CHECK(record::fault_words(PAL_FAULT_TABLE_LEFT) == "table-left");
    CHECK(record::fault_words(PAL_FAULT_TABLE_STALE) == "table-stale");
    CHECK(record::fault_words(PAL_FAULT_TABLE_DROPPED) == "table-dropped");
    CHECK(record::fault_words(PAL_FAULT_TABLE_BAD) == "table-bad");
    CHECK(record::fault_words(PAL_FAULT_FORCE_CLAMP) == "force-clamp");
    CHECK(record::fault_words(PAL_FAULT_MOTOR_CLAMP) == "motor-clamp");
    CHECK(record::fault_words(PAL_FAULT_LATE) == "late");
    CHECK(record::fault_words(PAL_FAULT_DEVICE_LOST) == "device-lost");
    CHECK(record::fault_words(PAL_FAULT_ESTOP) == "e-stop");
    CHECK(record::fault_words(PAL_FAULT_HOST_LOST) == "host-lost");
    CHECK(record::fault_words(PAL_FAULT_LATE | PAL_FAULT_TABLE_LEFT) == "table-left late");
    CHECK(record::fault_words(1U << 31) == "bit-31");
    CHECK(record::state_word(PAL_STATE_DISABLED) == "disabled");
    CHECK(record::state_word(PAL_STATE_HOMING) == "homing");
    CHECK(record::state_word(PAL_STATE_RAMP) == "ramp");
    CHECK(record::state_word(PAL_STATE_ENABLED) == "enabled");
    CHECK(record::state_word(PAL_STATE_PAUSED) == "paused");
    CHECK(record::state_word(PAL_STATE_FAULT) == "fault");
    CHECK(record::state_word(6) == "state-6");
    CHECK(record::stop_word(0) == "none");
    CHECK(record::stop_word(PAL_FAULT_DEVICE_LOST) == "device-lost");
}
