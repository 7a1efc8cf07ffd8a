// One of the three processes of a run in real time is killed, stopped or interrupted: the others end by
// themselves, say why, and the simulated Falcon's motors are off, read from its own process.
#include <catch2/catch.hpp>
#include <csignal>

#include "tests/host/app/processes.hpp"
#include "tests/host/app/sheet.hpp"

using namespace palpate::test;
using Catch::Matchers::Contains;

namespace {

constexpr double HOLD_S = 120.0;  // much longer than a test

/// A run in real time that has come to where the tool is pressed and the motors push back.
struct Pressing {
    Pressing()
        : palpate((adopt_orphans(), PAL_PALPATE_PROGRAM),
                  {"run", write_sheet(folder.path(), HOLD_S), "--clock", "real", "--out",
                   (folder / "result").string()},
                  folder) {
        nlohmann::json status;
        do {
            look_again();
            status = device_status(folder);
            INFO(palpate.err());
            REQUIRE(palpate.running());
        } while (status.is_null() || status["path_tick"] < 700 || motors_at_rest(status));
        loop = child_of(palpate.pid(), "palpate-loop");
        device = child_of(palpate.pid(), "palpate-falcon");
        REQUIRE(loop > 0);
        REQUIRE(device > 0);
    }
    [[nodiscard]] std::string log() const { return text_of(folder / "result" / "log.txt"); }
    [[nodiscard]] nlohmann::json summary() const { return json_of(folder / "result" / "summary.json"); }
    void check_nothing_is_left() const {
        CHECK(no_children());
        CHECK(scratch_in(folder).empty());
        CHECK(segments_of(palpate.pid()).empty());
        CHECK_FALSE(std::filesystem::exists(folder / "result.partial"));
    }

    Folder folder;
    Program palpate;
    pid_t loop = 0, device = 0;
};

}  // namespace

TEST_CASE("palpate is killed: the loop ends by itself, the device outlives both with its motors off",
          "[ends]") {
    Pressing run;
    run.palpate.send(SIGKILL);
    CHECK(run.palpate.wait() == -SIGKILL);
    CHECK(wait_for_orphan(run.loop) == 3);
    nlohmann::json status;
    do {
        look_again();
        status = device_status(run.folder);
        REQUIRE_FALSE(status.is_null());
    } while (status["connected"] == true);  // until it has read the loop's last packet
    INFO(status);
    CHECK(motors_at_rest(status));
    CHECK(wait_for_orphan(run.device) == 0);
    const std::string log = text_of(run.folder / "result.partial" / "log.txt");
    CHECK_THAT(log, Contains("palpate-loop: the host is gone; force is zero\n"));
    CHECK_THAT(
        log,
        Contains("palpate-falcon-sim: the process that started this one is gone; motor words at the end: "
                 "0 0 0\n"));
    CHECK(no_children());

    // What it could not remove itself, the next run does.
    CHECK(scratch_in(run.folder).size() == 1);
    CHECK(segments_of(run.palpate.pid()).size() == 1);
    const Outcome next = call(PAL_PALPATE_PROGRAM,
                              {"run", write_sheet(run.folder.path()), "--clock", "real", "--duration", "0.2",
                               "--out", (run.folder / "result").string()},
                              run.folder);
    INFO(next.err);
    CHECK(next.code == 0);
    run.check_nothing_is_left();
}

TEST_CASE("the loop is killed: palpate says so, and waits until the device's watchdog has the motors off",
          "[ends]") {
    Pressing run;
    kill(run.loop, SIGKILL);
    CHECK(run.palpate.wait() == 3);
    const nlohmann::json summary = run.summary();
    CHECK(summary["verdict"] == "fail");
    CHECK(summary["failure"] == "palpate-loop ended in mid-run (signal 9); see log.txt");
    CHECK_THAT(run.palpate.err(), Contains("palpate-loop ended in mid-run (signal 9)"));
    INFO(summary["device"]);
    CHECK(motors_at_rest(summary["device"]));
    CHECK(summary["device"]["watchdog"] == true);
    CHECK(summary["n_contact_ticks"] > 0);
    run.check_nothing_is_left();
}

TEST_CASE("the device is killed: the loop notices, palpate names the device and not the loop", "[ends]") {
    Pressing run;
    kill(run.device, SIGKILL);
    CHECK(run.palpate.wait() == 3);
    CHECK(run.summary()["verdict"] == "fail");
    CHECK(run.summary()["failure"] == "palpate-falcon-sim ended in mid-run (signal 9); see log.txt");
    CHECK(run.summary()["device"]["no_answer"] == true);
    CHECK_THAT(run.log(), Contains("palpate-loop: the device is gone\n"));
    run.check_nothing_is_left();
}

TEST_CASE("palpate stops without dying: the loop takes it for lost, and palpate says so when it goes on",
          "[ends]") {
    Pressing run;
    run.palpate.send(SIGSTOP);
    nlohmann::json status;
    do {
        look_again();
        status = device_status(run.folder);
        REQUIRE_FALSE(status.is_null());
    } while (status["connected"] == true);
    CHECK(motors_at_rest(status));
    run.palpate.send(SIGCONT);
    CHECK(run.palpate.wait() == 3);
    CHECK(run.summary()["failure"] == "palpate-loop ended in mid-run (exit 3, host-lost); see log.txt");
    run.check_nothing_is_left();
}

TEST_CASE("an interrupt ends a run in real time after zero force, with its results written", "[ends]") {
    const int signal = GENERATE(as<int>{}, SIGINT, SIGTERM);
    Pressing run;
    run.palpate.send(signal);
    CHECK(run.palpate.wait() == 130);
    const nlohmann::json summary = run.summary();
    CHECK(summary["verdict"] == "interrupted");
    CHECK(summary["failure"] == "");
    CHECK(motors_at_rest(summary["device"]));
    CHECK(summary["device"]["watchdog"] == false);  // it was told, it did not have to guess
    CHECK(summary["force_error_rms_relative"].is_null());
    CHECK_FALSE(text_of(run.folder / "result" / "run.palrec").empty());
    run.check_nothing_is_left();
}

TEST_CASE("an interrupt ends a run in virtual time likewise", "[ends]") {
    const Folder folder;
    Program palpate(PAL_PALPATE_PROGRAM,
                    {"run", write_sheet(folder.path(), 3000.0), "--out", (folder / "result").string()},
                    folder);
    while (palpate.err().find("stiffness:") == std::string::npos) {  // the bake is done
        look_again();
        REQUIRE(palpate.running());
    }
    palpate.send(SIGINT);
    CHECK(palpate.wait() == 130);
    CHECK(json_of(folder / "result" / "summary.json")["verdict"] == "interrupted");
}

TEST_CASE("an interrupt before the first tick leaves an earlier result as it was", "[ends]") {
    const Folder folder;
    std::filesystem::create_directory(folder / "result");
    write_text(folder / "result" / "summary.json", "{}\n");
    const auto before = files_below(folder / "result");
    Program palpate(PAL_PALPATE_PROGRAM,
                    {"run", write_sheet(folder.path(), 3000.0), "--out", (folder / "result").string()},
                    folder);
    while (!std::filesystem::exists(folder / "result.partial")) {
        look_again();
        REQUIRE(palpate.running());
    }
    palpate.send(SIGINT);
    CHECK(palpate.wait() == 130);
    CHECK(palpate.err() == "palpate: interrupted\n");
    CHECK(files_below(folder / "result") == before);
    CHECK_FALSE(std::filesystem::exists(folder / "result.partial"));
}
