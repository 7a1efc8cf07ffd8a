// palpate-loop on a Falcon on the USB, with this test as its host.
#include <catch2/catch.hpp>

#include "tests/firmware/loop_host.hpp"
#include "tests/firmware/usb_bench.hpp"

using namespace usbbench;
using loophost::Host;
using usbtest::Bus;
using usbtest::Process;

namespace {

/// palpate-loop on the bus' first Falcon.
std::vector<std::string> loop_on_usb(const Host& host, const Folder& folder) {
    return {usbtest::client("palpate-loop"),
            "--link",
            host.name(),
            "--device",
            "usb:PALSIM01",
            "--firmware",
            folder.firmware(),
            "--ramp-ticks",
            "20"};
}

}  // namespace

TEST_CASE(
    "palpate-loop boots a Falcon, survives its unplugging, and pushes again only when the operator says so",
    "[process]") {
    const Folder folder;
    // Answers in every tick: a simulated device would be let back in after 200 of them.
    const Bus bus(
        {"--timing", "immediate", "--grip", "firm", "--path", folder.path(), "--ramp-ticks", "100"});
    Host host;
    Process loop(loop_on_usb(host, folder), Bus::environment());
    REQUIRE(host.is_enabled());
    // A machine that stalled the loop as long as a lost device would has stopped it as one.
    if (host.newest().n_missed < 20) CHECK((host.faults_seen() & PAL_FAULT_DEVICE_LOST) == 0);
    CHECK(device_status()["boots"] == 1);
    fault("unplug at_s=0 for_s=0.2");
    REQUIRE(host.comes_to(PAL_STATE_FAULT));
    CHECK((host.faults_seen() & PAL_FAULT_DEVICE_LOST) != 0);
    // Back, booted and homed: the stop stays.
    for (bool homed = false; !homed;) {
        REQUIRE(host.comes_to(PAL_STATE_FAULT));
        const json device = device_status();
        homed = device["boots"] == 2 && device["homed"] == true;
    }
    for (const std::uint32_t then = host.newest().tick; host.newest().tick < then + 500;) {
        poll(nullptr, 0, 2);
        REQUIRE(host.comes_to(PAL_STATE_FAULT));
    }
    host.enable(false);
    REQUIRE(host.comes_to(PAL_STATE_PAUSED));
    REQUIRE(host.is_enabled());
    pal_link_store(&host.link().host.stop, 1);
    const std::string words = loop.words();
    INFO(words);
    CHECK(loop.wait() == 0);
    CHECK(times_in(words, "The Falcon was unplugged") == 1);
    CHECK(times_in(words, "Falcon PALSIM01 is back") == 1);
    CHECK(at_rest(device_status()));
    CHECK(device_status()["open"] == 0);
}

TEST_CASE("on the USB a tick's stamps are those of the transfers, in the order of what happened",
          "[process]") {
    const Folder folder;
    const Bus bus({"--timing", "immediate", "--grip", "firm"});
    Host host;
    Process loop(loop_on_usb(host, folder), Bus::environment());
    REQUIRE(host.is_enabled());
    host.keep(true);
    REQUIRE(host.until([&] { return host.kept().size() > 300; }));
    pal_link_store(&host.link().host.stop, 1);
    CHECK(loop.wait() == 0);
    int n_replies = 0, n_ends = 0;
    for (std::size_t i = 1; i < host.kept().size(); ++i) {
        const std::uint64_t* before_ns = host.kept()[i - 1].stamp_ns;
        const std::uint64_t* now_ns = host.kept()[i].stamp_ns;
        CHECK(now_ns[1] == host.kept()[i].t_ns);
        CHECK((now_ns[1] < now_ns[2] && now_ns[2] <= now_ns[3]));
        if (now_ns[4] != 0) CHECK(now_ns[3] <= now_ns[4]);
        CHECK(now_ns[5] >= before_ns[5]);  // ends are known in their order
        if (now_ns[0] != 0) {
            ++n_replies;
            CHECK((now_ns[0] > before_ns[1] && now_ns[0] < now_ns[2]));
        }
        if (before_ns[4] == 0 || now_ns[5] < before_ns[4]) continue;
        ++n_ends;  // of the request before, or already of this one
    }
    CHECK(n_replies > 200);
    CHECK(n_ends > 200);
}

TEST_CASE("a killed loop's Falcon is taken over by --zero, without booting it again", "[process]") {
    const Folder folder;
    const Bus bus({"--timing", "immediate", "--grip", "firm", "--watchdog-ms", "60000"});
    Host host;
    host.offer_skin();
    const auto zero = [] {
        Process process({usbtest::client("palpate-loop"), "--zero", "--device", "usb:PALSIM01"},
                        Bus::environment());
        const std::string words = process.words();
        return usbtest::Outcome{process.wait(), words};
    };
    {
        Process loop(loop_on_usb(host, folder), Bus::environment());
        REQUIRE(host.is_enabled());
        loop.send(SIGKILL);
        CHECK(loop.wait() == 128 + SIGKILL);
    }
    const usbtest::Outcome outcome = zero();
    INFO(outcome.words);
    CHECK(outcome.code == 0);
    CHECK(outcome.words.empty());
    CHECK(at_rest(device_status()));
    CHECK(device_status()["boots"] == 1);
}

TEST_CASE("palpate-loop says why a Falcon cannot be had", "[process]") {
    const Folder folder;
    Host host;
    const auto loop = [&](const std::string& device, const std::string& firmware) {
        return usbtest::run({"--timing", "immediate"},
                            {usbtest::client("palpate-loop"), "--link", host.name(), "--device", device,
                             "--firmware", firmware});
    };
    const usbtest::Outcome other = loop("usb:FALCON9", folder.firmware());
    CHECK(other.code == 3);
    CHECK(times_in(other.words, "No Falcon with serial number FALCON9") == 1);
    const usbtest::Outcome none = loop("usb", folder / "none.bin");
    CHECK(none.code == 2);
    CHECK(times_in(none.words, "nvent_firmware.bin") >= 1);
}
