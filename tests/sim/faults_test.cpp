#include "sim/falcon/faults.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

namespace {

struct Parsed {
    int n;
    std::vector<pal_usb_fault> faults;
    std::string message;
};

Parsed parse(const std::string& text) {
    Parsed parsed{0, std::vector<pal_usb_fault>(PAL_USB_FAULTS_MAX), ""};
    pal_usb_fault_error error{};
    parsed.n =
        pal_usb_faults_parse(text.data(), text.size(), parsed.faults.data(), parsed.faults.size(), &error);
    parsed.message = error.message;
    return parsed;
}

pal_usb_fault fault_of(const std::string& line) {
    const Parsed parsed = parse(line);
    INFO(parsed.message);
    REQUIRE(parsed.n == 1);
    return parsed.faults[0];
}

}  // namespace

TEST_CASE("a scenario is read line by line: kinds, times, parameters, comments") {
    const Parsed parsed = parse(
        "# a bad day\n"
        "unplug at_s=2 for_s=0.1\r\n"
        "\n"
        "  corrupt   at_s=1.5 for_s=0.2 p=0.01 dir=both # both ways\n"
        "boot-fail stage=5 byte=300 n=2\n"
        "jump axis=2 counts=-250 at_s=0.000001\n"
        "split byte=3 gap_s=0.002 n=7\n"
        "stall ep=control for_s=1\n"
        "babble length=3 every_s=0.01 for_s=1000000\n"
        "delay by_s=.5 dir=out\n"
        "slow-host at_s=2 for_s=0.05\n"
        "slow-host for_s=0.05 every_s=0.25 n=4");
    INFO(parsed.message);
    REQUIRE(parsed.n == 10);
    const auto& f = parsed.faults;
    CHECK(f[0].kind == PAL_USB_FAULT_UNPLUG);
    CHECK(f[0].at_us == 2000000);
    CHECK(f[0].for_us == 100000);
    CHECK(f[1].kind == PAL_USB_FAULT_CORRUPT);
    CHECK(f[1].at_us == 1500000);
    CHECK(f[1].per_million == 10000);
    CHECK(f[1].dir == PAL_USB_FAULT_BOTH);
    CHECK(f[2].stage == 5);
    CHECK(f[2].byte == 300);
    CHECK(f[2].n == 2);
    CHECK(f[3].axis == 2);
    CHECK(f[3].counts == -250);
    CHECK(f[3].at_us == 1);
    CHECK(f[4].byte == 3);
    CHECK(f[4].gap_us == 2000);
    CHECK(f[5].endpoints == PAL_USB_FAULT_EP_CONTROL);
    CHECK(f[6].length == 3);
    CHECK(f[6].every_us == 10000);
    CHECK(f[7].by_us == 500000);
    CHECK(f[7].dir == PAL_USB_FAULT_OUT);
    CHECK(f[8].kind == PAL_USB_FAULT_SLOW_HOST);
    CHECK(f[8].at_us == 2000000);
    CHECK(f[8].for_us == 50000);
    CHECK(f[8].every_us == 0);
    CHECK(f[9].every_us == 250000);
    CHECK(f[9].n == 4);
}

TEST_CASE("a line that is wrong is refused with its number, what is wrong and what would be right") {
    struct Row {
        const char *text, *line, *what, *right;
    };
    const Row row = GENERATE(as<Row>{}, Row{"unplugg", "line 1: ", "unplugg", "unplug power-out"},
                             Row{"\n\nunplug for_s=1 at=2", "line 3: ", "at", "at_s"},
                             Row{"drop at_s", "line 1: ", "at_s", "name=value"},
                             Row{"drop at_s=", "line 1: ", "at_s=", "such as 0.1"},
                             Row{"drop at_s=-1", "line 1: ", "at_s=-1", "0 to 1000000"},
                             Row{"drop at_s=1e3", "line 1: ", "at_s=1e3", "such as 0.1"},
                             Row{"drop at_s=0.0000001", "line 1: ", "at_s=0.0000001", "microsecond"},
                             Row{"drop at_s=1000001", "line 1: ", "at_s=1000001", "1000000"},
                             Row{"drop at_s=18446744073710", "line 1: ", "at_s=18446744073710", "1000000"},
                             Row{"drop p=18446744073710", "line 1: ", "p=18446744073710", "0 to 1"},
                             Row{"drop n=0", "line 1: ", "n=0", "1 to 1000000000"},
                             Row{"drop at_s=1 at_s=2", "line 1: ", "at_s", "twice"},
                             Row{"drop p=1.1", "line 1: ", "p=1.1", "0 to 1"},
                             Row{"drop n=1.5", "line 1: ", "n=1.5", "whole"},
                             Row{"drop dir=up", "line 1: ", "dir=up", "in, out or both"},
                             Row{"drop counts=3", "line 1: ", "counts", "leave it out"},
                             Row{"unplug", "line 1: ", "unplug", "for_s=0.1"},
                             Row{"freeze axis=4 for_s=1", "line 1: ", "axis=4", "1, 2 or 3"},
                             Row{"boot-fail stage=0", "line 1: ", "boot-fail", "1 to 7"},
                             Row{"split byte=62", "line 1: ", "split", "1 to 61"},
                             Row{"jump counts=40000", "line 1: ", "counts=40000", "32767"},
                             Row{"babble length=65", "line 1: ", "length=65", "1 to 64"},
                             Row{"babble every_s=0", "line 1: ", "babble", "every_s"},
                             Row{"slow-host", "line 1: ", "slow-host", "for_s=0.1"},
                             Row{"slow-host for_s=1 every_s=1", "line 1: ", "slow-host", "longer than for_s"},
                             Row{"slow-host for_s=1 n=2", "line 1: ", "slow-host", "every_s=1"},
                             Row{"slow-host for_s=1 dir=in", "line 1: ", "dir", "leave it out"},
                             Row{"slowhost for_s=1", "line 1: ", "slowhost", "slow-host"});
    const Parsed parsed = parse(row.text);
    CHECK(parsed.n == -1);
    CHECK_THAT(parsed.message,
               Catch::StartsWith(row.line) && Catch::Contains(row.what) && Catch::Contains(row.right));
}

TEST_CASE("more faults than there is room for are refused") {
    std::string text;
    for (int i = 0; i < PAL_USB_FAULTS_MAX; ++i) text += "drop\n";
    CHECK(parse(text).n == PAL_USB_FAULTS_MAX);
    CHECK(parse(text + "# nothing\n").n == PAL_USB_FAULTS_MAX);
    CHECK(parse(text + "drop\n").n == -1);
}

TEST_CASE("every kind has a name, which reads as itself") {
    for (int kind = 0; kind < PAL_USB_FAULT_KINDS; ++kind) {
        const auto which = static_cast<pal_usb_fault_kind>(kind);
        const bool lasts = which == PAL_USB_FAULT_UNPLUG || which == PAL_USB_FAULT_POWER_OUT ||
                           which == PAL_USB_FAULT_FREEZE || which == PAL_USB_FAULT_SLOW_HOST;
        CHECK(fault_of(std::string(pal_usb_fault_name(which)) + (lasts ? " for_s=1" : "")).kind == which);
    }
}
