// The rig's e-stop against the run's own ticks, and clients that do nothing.
#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <utility>

#include "host/app/rig_operator.hpp"
#include "tests/host/app/processes.hpp"
#include "tests/host/app/sheet.hpp"
#include "tests/host/rig/client.hpp"
#include "tests/lacking.hpp"

using namespace palpate;
using namespace palpate::test;
using Catch::Matchers::Contains;

namespace {

constexpr std::uint32_t WITHIN_TICKS = 3;
constexpr std::uint32_t STOP_AT_PATH_TICK = 900;  // in mid-stroke

Outcome mbpoll(const std::string& port, const std::vector<std::string>& what, const Folder& folder) {
    std::vector<std::string> arguments{"-m", "tcp", "-0", "-1", "-o", "10", "-p", port};
    arguments.insert(arguments.end(), what.begin(), what.end());
    return call("mbpoll", arguments, folder);
}

Outcome write_estop(const std::string& port, const char* value, const Folder& folder) {
    return mbpoll(port, {"-t", "0", "-r", "0", "127.0.0.1", value}, folder);
}

bool no_force(const pal_tick& tick) {
    return tick.motor_counts[0] == 0 && tick.motor_counts[1] == 0 && tick.motor_counts[2] == 0;
}

/// What a stop that was asked for after the tick `asked` must have done.
void check_stopped(const std::vector<pal_tick>& ticks, std::uint32_t asked) {
    REQUIRE(ticks.size() > asked + WITHIN_TICKS);
    CHECK_FALSE(no_force(ticks[asked]));
    for (std::size_t i = asked + WITHIN_TICKS; i < ticks.size(); ++i) {
        if (no_force(ticks[i]) && ticks[i].stop == PAL_FAULT_ESTOP && ticks[i].state == PAL_STATE_FAULT)
            continue;
        FAIL("tick " << i << ": force, or no e-stop, after it was asked for in tick " << asked);
    }
}

app::Prepared prepared(const Folder& folder) {
    app::Progress quiet(true);
    return app::prepare(scene::build(sheet_scene(folder.path())), quiet);
}

app::RunResult run(const app::Prepared& prepared, const app::Operator& rig) {
    app::Progress quiet(true);
    return app::run_virtual(prepared, rig, quiet);
}

/// A rig that acts once, between two ticks: when it returns, virtual time has not moved.
struct Acting {
    Acting(app::Operator inner, std::function<void()> act) : as_operator(inner) {
        as_operator.show = [this, inner, act](const pal_tick& tick, double rate_hz) {
            inner.show(tick, rate_hz);
            if (tick.path_tick != STOP_AT_PATH_TICK) return;
            asked = tick.tick;
            act();
        };
    }
    app::Operator as_operator;
    std::uint32_t asked = 0;
};

/// The port that a run with --rig 127.0.0.1:0 took, once it serves.
std::string port_of(Program& palpate) {
    const std::string key = "Modbus TCP on port ";
    std::string words;
    do {
        look_again();
        REQUIRE(palpate.running());
        words = palpate.err();
    } while (words.find(key) == std::string::npos || words.back() != '\n');
    return std::to_string(std::stoi(words.substr(words.find(key) + key.size())));
}

}  // namespace

TEST_CASE("an e-stop that is asked for once holds to the end, force zero within three ticks", "[rig]") {
    const Folder folder;
    bool now = false;
    Acting rig({.estop = [&now] { return std::exchange(now, false); }}, [&now] { now = true; });
    const app::RunResult result = run(prepared(folder), rig.as_operator);
    check_stopped(result.ticks, rig.asked);
}

TEST_CASE("mbpoll's e-stop reaches the motors within three ticks of its arrival, and 0 releases nothing",
          "[rig]") {
    if (mbpoll_is_missing()) return;
    const Folder folder;
    app::Progress quiet(true);
    app::RigOperator server("127.0.0.1:0", quiet);
    const std::string port = std::to_string(server.port());
    Acting rig(server.as_operator(), [&] {
        CHECK(write_estop(port, "1", folder).code == 0);
        CHECK(write_estop(port, "0", folder).code != 0);
    });
    const app::RunResult result = run(prepared(folder), rig.as_operator);
    check_stopped(result.ticks, rig.asked);
}

TEST_CASE("a silent client, and one that stops in mid-frame, change nothing in the run", "[rig]") {
    const Folder folder;
    const app::Prepared scene = prepared(folder);
    const app::RunResult alone = run(scene, {});
    app::Progress quiet(true);
    app::RigOperator server("127.0.0.1:0", quiet);
    const rig::test::Client silent(server.port());
    rig::test::Client half_open(server.port());
    REQUIRE(half_open.send(rig::test::hex("00 01 00 00 00 06 01")));
    const app::RunResult watched = run(scene, server.as_operator());
    CHECK(watched.digest_io == alone.digest_io);
    CHECK(watched.digest_state == alone.digest_state);
}

TEST_CASE("the rig is served before anything is solved", "[rig]") {
    if (mbpoll_is_missing()) return;
    const Folder folder;
    Program palpate(PAL_PALPATE_PROGRAM,
                    {"run", write_sheet(folder.path(), 3000.0), "--rig", "127.0.0.1:0", "--out",
                     (folder / "result").string()},
                    folder);
    const std::string port = port_of(palpate);
    const Outcome words = mbpoll(port, {"-t", "3", "-r", "0", "-c", "16", "127.0.0.1"}, folder);
    INFO(words.out << words.err);
    CHECK(words.code == 0);
    CHECK_THAT(words.out, Contains("[0]: \t0") && Contains("[15]: \t"));  // disabled: no loop runs yet
    CHECK(palpate.err().find("stiffness:") == std::string::npos);
    CHECK(write_estop(port, "1", folder).code == 0);  // and is heard already
    CHECK(palpate.err().find("stiffness:") == std::string::npos);
    palpate.send(SIGKILL);
}

TEST_CASE("the coil for forces pauses them and gives them back, with the ramp", "[rig]") {
    const Folder folder;
    constexpr std::uint32_t PAUSED_TICKS = 100;
    bool on = true;
    app::Operator rig{.enable = [&on] { return on; }};
    std::uint32_t paused = 0;
    rig.show = [&](const pal_tick& tick, double) {
        if (tick.path_tick == STOP_AT_PATH_TICK) paused = tick.tick;
        on = paused == 0 || tick.tick >= paused + PAUSED_TICKS;
    };
    const std::vector<pal_tick> ticks = run(prepared(folder), rig).ticks;
    REQUIRE(ticks.size() > paused + 2 * PAUSED_TICKS);
    REQUIRE_FALSE(no_force(ticks[paused]));
    for (std::uint32_t i = paused + WITHIN_TICKS; i <= paused + PAUSED_TICKS; ++i) {
        INFO("tick " << i);
        CHECK(no_force(ticks[i]));
        CHECK(ticks[i].state == PAL_STATE_PAUSED);
    }
    CHECK(ticks[paused + PAUSED_TICKS + WITHIN_TICKS].state == PAL_STATE_RAMP);
    CHECK(ticks.back().state == PAL_STATE_ENABLED);
}

TEST_CASE("clients that are silent or stop in mid-frame keep nobody waiting in real time", "[rig]") {
    if (mbpoll_is_missing()) return;
    const Folder folder;
    Program palpate(PAL_PALPATE_PROGRAM,
                    {"run", write_sheet(folder.path(), 300.0), "--clock", "real", "--rig", "127.0.0.1:0",
                     "--out", (folder / "result").string()},
                    folder);
    const std::string port = port_of(palpate);
    const auto number = static_cast<std::uint16_t>(std::stoi(port));
    const rig::test::Client silent(number);
    rig::test::Client half_open(number);
    REQUIRE(half_open.send(rig::test::hex("00 01 00 00 00 06 01")));
    std::string words;
    do {
        look_again();
        REQUIRE(palpate.running());
        words = mbpoll(port, {"-t", "3", "-r", "0", "-c", "16", "127.0.0.1"}, folder).out;
    } while (words.find("[0]: \t3\n") == std::string::npos);  // enabled: homing, ramp and loop went on
    CHECK(write_estop(port, "1", folder).code == 0);
    do {
        look_again();
        REQUIRE(palpate.running());
        words = mbpoll(port, {"-t", "3", "-r", "0", "-c", "16", "127.0.0.1"}, folder).out;
    } while (words.find("[0]: \t5\n") == std::string::npos);
    palpate.send(SIGINT);
    CHECK(palpate.wait() == 130);
    const record::Record record = record::read(folder / "result" / "run.palrec");
    for (std::size_t i = 1; i < record.ticks.size(); ++i) {  // the loop never waited: no record is missing
        if (record.ticks[i].tick != record.ticks[i - 1].tick + 1)
            FAIL("records end at " << record.ticks[i].tick);
    }
}

TEST_CASE("mbpoll reads and stops a run of the program, whose results say so", "[rig]") {
    if (mbpoll_is_missing()) return;
    const std::string clock = GENERATE(as<std::string>{}, "virtual", "real");
    const Folder folder;
    Program palpate(PAL_PALPATE_PROGRAM,
                    {"run", write_sheet(folder.path(), 300.0), "--clock", clock, "--rig", "127.0.0.1:0",
                     "--out", (folder / "result").string()},
                    folder);
    const std::string port = port_of(palpate);
    const std::vector<std::string> read{"-t", "3", "-r", "0", "-c", "16", "127.0.0.1"};
    std::string words;
    do {
        look_again();
        REQUIRE(palpate.running());
        words = mbpoll(port, read, folder).out;
    } while (words.find("[0]: \t3\n") == std::string::npos);  // enabled
    CHECK(write_estop(port, "1", folder).code == 0);
    do {
        look_again();
        REQUIRE(palpate.running());
        words = mbpoll(port, read, folder).out;
    } while (words.find("[0]: \t5\n") == std::string::npos);  // latched
    CHECK(write_estop(port, "0", folder).code != 0);
    palpate.send(SIGINT);
    CHECK(palpate.wait() == 130);
    CHECK(json_of(folder / "result" / "summary.json")["stop"] == "e-stop");
    const record::Record record = record::read(folder / "result" / "run.palrec");
    REQUIRE_FALSE(record.ticks.empty());
    const auto seen = std::find_if(record.ticks.begin(), record.ticks.end(),
                                   [](const pal_tick& tick) { return (tick.faults & PAL_FAULT_ESTOP) != 0; });
    REQUIRE(seen != record.ticks.end());
    CHECK(seen - record.ticks.begin() > 0);
    for (auto tick = seen + WITHIN_TICKS; tick < record.ticks.end(); ++tick) {
        if (!no_force(*tick))
            FAIL("tick " << tick->tick << ": force after the e-stop in tick " << seen->tick);
    }
    CHECK(record.ticks.back().stop == PAL_FAULT_ESTOP);
    CHECK_THAT(text_of(folder / "result" / "events.csv"), Contains("stop,e-stop"));
}
