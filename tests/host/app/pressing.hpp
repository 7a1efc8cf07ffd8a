/// A run in real time in mid-press, with its processes.
#pragma once
#include <catch2/catch.hpp>
#include <csignal>
#include <memory>

#include "tests/host/app/processes.hpp"
#include "tests/host/app/sheet.hpp"

namespace palpate::test {

inline constexpr double HOLD_S = 120.0;  // much longer than a test

/// A run in real time that has come to where the tool is pressed and the motors push back. A machine that
/// stalls everything for 20 ms on the way there leaves the tool inside the skin without a table, for good:
/// then another run is begun, a few times.
struct Pressing {
    Pressing() {
        adopt_orphans();
        for (int n = 0; n < TRIES_MAX && !begin(); ++n) {
            palpate->send(SIGINT);
            REQUIRE(palpate->wait() == 130);
        }
        loop = child_of(palpate->pid(), "palpate-loop");
        device = child_of(palpate->pid(), "palpate-falcon-sim");
        builder = child_of(palpate->pid(), "palpate-tables");
        REQUIRE(loop > 0);
        REQUIRE(builder > 0);
        REQUIRE(device > 0);
    }
    [[nodiscard]] std::string log() const { return text_of(folder / "result" / "log.txt"); }
    [[nodiscard]] nlohmann::json summary() const { return json_of(folder / "result" / "summary.json"); }
    /// Kills palpate, and waits until the loop and the table builder have ended and the device has read the
    /// loop's last packet; what it then says of itself.
    nlohmann::json kill_palpate() {
        palpate->send(SIGKILL);
        CHECK(palpate->wait() == -SIGKILL);
        CHECK(wait_for_orphan(loop) == 3);
        CHECK(wait_for_orphan(builder) == -SIGKILL);
        nlohmann::json status;
        do {
            look_again();
            status = device_status(folder);
            REQUIRE_FALSE(status.is_null());
        } while (status["connected"] == true);
        return status;
    }
    void check_nothing_is_left() const {
        CHECK(no_children());
        CHECK(scratch_in(folder).empty());
        CHECK(segments_of(palpate->pid()).empty());
        CHECK_FALSE(std::filesystem::exists(folder / "result.partial"));
    }

    Folder folder;
    std::unique_ptr<Program> palpate;
    pid_t loop = 0, device = 0, builder = 0;

private:
    static constexpr int TRIES_MAX = 5;
    static constexpr int PRESSED_TICK = 700, HOPELESS_TICK = 4000;  // of the path

    [[nodiscard]] bool begin() {
        palpate = std::make_unique<Program>(
            PAL_PALPATE_PROGRAM,
            std::vector<std::string>{"run", write_sheet(folder.path(), HOLD_S), "--clock", "real", "--out",
                                     (folder / "result").string()},
            folder);
        nlohmann::json status;
        do {
            look_again();
            status = device_status(folder);
            INFO(palpate->err());
            REQUIRE(palpate->running());
            if (!status.is_null() && status["path_tick"] > HOPELESS_TICK) return false;
        } while (status.is_null() || status["path_tick"] < PRESSED_TICK || motors_at_rest(status));
        return true;
    }
};

}  // namespace palpate::test
