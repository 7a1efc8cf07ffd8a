// One of the processes of a run in real time is killed, stopped or interrupted: the others end by themselves
// or go on without it, say why, and the simulated Falcon's motors are off at the end, read from its own
// process.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>

#include "host/record/record.hpp"
#include "tests/host/app/pressing.hpp"

using namespace palpate::test;
using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;
using Catch::Matchers::StartsWith;

TEST_CASE("palpate is killed: the loop ends by itself, the device outlives both with its motors off",
          "[ends]") {
    Pressing run;
    const nlohmann::json status = run.kill_palpate();
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

    // What it could not remove itself, the next run does; a measurement leaves its last ticks for that.
    CHECK(scratch_in(run.folder).size() == 1);
    CHECK(call(PAL_PALPATE_PROGRAM, {"device", "latency", "--device", "sim", "--seconds", "1"}, run.folder)
              .code < 2);
    CHECK(segments_of(run.palpate->pid()).size() == 1);
    const Outcome next = call(PAL_PALPATE_PROGRAM,
                              {"run", write_sheet(run.folder.path()), "--clock", "real", "--duration", "0.2",
                               "--out", (run.folder / "result").string()},
                              run.folder);
    INFO(next.err);
    CHECK(next.code == 0);
    const std::string orphan =
        "orphan-palpate-" + std::to_string(getuid()) + "-" + std::to_string(run.palpate->pid()) + ".palrec";
    CHECK_THAT(next.err, Contains("a run that was killed left its last "));
    const palpate::record::Record left = palpate::record::read(run.folder / "result" / orphan);
    CHECK(left.ticks.size() > 700);
    CHECK(left.ticks.back().stop == PAL_FAULT_HOST_LOST);
    run.check_nothing_is_left();
}

TEST_CASE("the loop is killed or stands still: palpate sends zero force in its place and says so", "[ends]") {
    const int signal = GENERATE(as<int>{}, SIGKILL, SIGSTOP);
    Pressing run;
    kill(run.loop, signal);
    CHECK(run.palpate->wait() == 3);
    const nlohmann::json summary = run.summary();
    CHECK(summary["verdict"] == "fail");
    const std::string failure = summary["failure"];
    if (signal == SIGKILL) {
        CHECK(failure == "palpate-loop ended in mid-run (signal 9); see log.txt");
    } else {
        CHECK_THAT(failure, StartsWith("palpate-loop stood still at tick ") && EndsWith(" and was killed"));
    }
    CHECK_THAT(run.palpate->err(), Contains(failure));
    INFO(summary["device"] << summary["supervision"]);
    CHECK(summary["supervision"]["take_over"]["done"] == true);
    CHECK(summary["supervision"]["take_over"]["words"] == "palpate sent zero force in its place");
    CHECK(motors_at_rest(summary["device"]));
    CHECK(summary["n_contact_ticks"] > 0);
    REQUIRE(summary["supervision"]["flight_records"] == nlohmann::json{"flight-1.palrec"});
    const palpate::record::Record flight = palpate::record::read(run.folder / "result" / "flight-1.palrec");
    CHECK(flight.header["flight"]["reason"] == failure);
    CHECK(flight.ticks.size() == std::min<std::size_t>(2000, summary["n_ticks"]));
    run.check_nothing_is_left();
}

TEST_CASE("the table builder is killed: another goes on in the same contact, and the loop goes on meanwhile",
          "[ends]") {
    Pressing run;
    kill(run.builder, SIGKILL);
    pid_t next = 0;
    do {
        look_again();
        REQUIRE(run.palpate->running());
        next = child_of(run.palpate->pid(), "palpate-tables");
    } while (next == 0 || next == run.builder);
    const std::uint64_t first_id = std::uint64_t{1} << 32;  // of the second builder
    const auto uses_it = [&] {
        const nlohmann::json status = device_status(run.folder);
        return !status.is_null() && status["path_tick"] > 2500;
    };
    while (!uses_it()) {
        look_again();
        REQUIRE(run.palpate->running());
    }
    run.palpate->send(SIGINT);
    CHECK(run.palpate->wait() == 130);
    const nlohmann::json summary = run.summary();
    INFO(summary["supervision"]);
    REQUIRE(summary["supervision"]["table_builder_restarts"].size() == 1);
    CHECK(summary["supervision"]["table_builder_restarts"][0]["why"] == "signal 9");
    CHECK(summary["supervision"]["table_builder_restarts"][0]["table_after_s"].is_number());
    CHECK(summary["stop"] == "none");
    const palpate::record::Record record = palpate::record::read(run.folder / "result" / "run.palrec");
    CHECK(record.ticks.back().table_id > first_id);
    CHECK(record.tables.contains(record.ticks.back().table_id));
    CHECK(record.ticks.back().depth_m > 0.0F);
    run.check_nothing_is_left();
}

TEST_CASE("a table builder that dies again and again without a table ends the run, which says so", "[ends]") {
    adopt_orphans();
    const Folder folder;
    Program palpate(PAL_PALPATE_PROGRAM,
                    {"run", write_sheet(folder.path(), HOLD_S), "--clock", "real", "--set", "touch.ramp_s=30",
                     "--out", (folder / "result").string()},  // no table before the ramp's end
                    folder);
    pid_t last = 0;
    while (palpate.running()) {
        const pid_t builder = child_of(palpate.pid(), "palpate-tables");
        if (builder != 0 && builder != last) {
            kill(builder, SIGKILL);
            last = builder;
        }
        look_again();
    }
    CHECK(palpate.wait() == 3);
    const nlohmann::json summary = json_of(folder / "result" / "summary.json");
    CHECK(summary["failure"] == "the table builder died 6 times in a row without a table (signal 9)");
    CHECK(summary["supervision"]["table_builder_restarts"].size() == 5);
    CHECK(motors_at_rest(summary["device"]));
    CHECK(no_children());
}

TEST_CASE("the device is killed: the loop notices, palpate names the device and not the loop", "[ends]") {
    Pressing run;
    kill(run.device, SIGKILL);
    CHECK(run.palpate->wait() == 3);
    CHECK(run.summary()["verdict"] == "fail");
    CHECK(run.summary()["failure"] == "palpate-falcon-sim ended in mid-run (signal 9); see log.txt");
    CHECK(run.summary()["device"]["no_answer"] == true);
    CHECK_THAT(run.log(), Contains("palpate-loop: the device is gone\n"));
    run.check_nothing_is_left();
}

TEST_CASE("palpate stops without dying: the loop takes it for lost, and palpate says so when it goes on",
          "[ends]") {
    Pressing run;
    run.palpate->send(SIGSTOP);
    nlohmann::json status;
    do {
        look_again();
        status = device_status(run.folder);
        REQUIRE_FALSE(status.is_null());
    } while (status["connected"] == true);
    CHECK(motors_at_rest(status));
    run.palpate->send(SIGCONT);
    CHECK(run.palpate->wait() == 3);
    CHECK(run.summary()["failure"] == "palpate-loop ended in mid-run (exit 3, host-lost); see log.txt");
    run.check_nothing_is_left();
}

TEST_CASE("an interrupt ends a run in real time after zero force, with its results written", "[ends]") {
    const int signal = GENERATE(as<int>{}, SIGINT, SIGTERM);
    Pressing run;
    run.palpate->send(signal);
    CHECK(run.palpate->wait() == 130);
    const nlohmann::json summary = run.summary();
    CHECK(summary["verdict"] == "interrupted");
    CHECK(summary["failure"] == "");
    CHECK(motors_at_rest(summary["device"]));
    CHECK(summary["device"]["watchdog"] == false);  // it was told, it did not have to guess
    CHECK(summary["force_error_rms_relative"].is_null());
    CHECK_FALSE(text_of(run.folder / "result" / "run.palrec").empty());
    run.check_nothing_is_left();
}

TEST_CASE("two runs side by side keep out of each other's way", "[ends]") {
    Pressing one, other;
    CHECK(segments_of(one.palpate->pid()).size() == 1);
    CHECK(segments_of(other.palpate->pid()).size() == 1);
    one.palpate->send(SIGINT);
    CHECK(one.palpate->wait() == 130);
    CHECK(other.palpate->running());
    CHECK_FALSE(device_status(other.folder).is_null());
    other.palpate->send(SIGINT);
    CHECK(other.palpate->wait() == 130);
    for (const Pressing* run : {&one, &other}) {
        CHECK(run->summary()["n_contact_ticks"] > 0);
        CHECK(motors_at_rest(run->summary()["device"]));
    }
    other.check_nothing_is_left();
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
