/// A run in real time in mid-press, with its processes.
#pragma once
#include <catch2/catch.hpp>

#include "tests/host/app/processes.hpp"
#include "tests/host/app/sheet.hpp"

namespace palpate::test {

inline constexpr double HOLD_S = 120.0;  // much longer than a test

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
        builder = child_of(palpate.pid(), "palpate-tables");
        REQUIRE(loop > 0);
        REQUIRE(builder > 0);
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
    pid_t loop = 0, device = 0, builder = 0;
};

}  // namespace palpate::test
