// A loop that pushes loses its Falcon at any moment: the motors are off, it is said, and it goes on after the
// Falcon is back, booted and homed. A loop that dies or hangs leaves no force either. Motors are read from
// the simulator.
#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <random>

#include "tests/firmware/usb_bench.hpp"

using namespace usbbench;
using usbtest::Bus;
using usbtest::Process;

namespace {

constexpr const char* WORD = "300";  // some 2 N

std::vector<std::string> push(const Folder& folder) {
    return {usbtest::client("usb_push"), folder.firmware(), WORD};
}

std::vector<std::string> hand(const Folder& folder, const std::string& timing) {
    return {"--timing", timing, "--grip", "firm", "--path", folder.path(), "--ramp-ticks", "100"};
}

bool pushes(const json& device) {
    return device["motor_counts"] == json::array({300, 300, 300});
}

}  // namespace

TEST_CASE(
    "whenever the Falcon is unplugged its motors end at zero, and it is pushed again only after a new boot "
    "and "
    "homing",
    "[process][unplug]") {
    const std::uint64_t seed = 20261130;
    const int n = usbtest::soak() ? 500 : 10;
    std::mt19937_64 random(seed);
    const Folder folder;
    const std::string timing = GENERATE(as<std::string>{}, "immediate", "frames");
    const Bus bus(hand(folder, timing));
    // Into a file: a pipe that nobody reads is full after some 270 unplugs, and then the loop stands still.
    const std::string said = folder / "said";
    std::vector<std::string> argv{"/bin/sh", "-c", "exec \"$0\" \"$@\" > " + said + " 2>&1"};
    for (const std::string& word : push(folder)) argv.push_back(word);
    Process program(argv, Bus::environment());
    int n_boots = 0;
    int n_in_force = 0;
    for (int i = 0; i < n; ++i) {
        const bool waits = random() % 4 != 0;  // for the force; else it may be while it boots or homes
        const auto after_us = static_cast<useconds_t>(random() % (waits ? 20000 : 400000));
        const std::string out_s = random() % 2 == 0 ? "0.4" : "0.02";
        CAPTURE(seed, i, timing, waits, after_us, out_s);
        if (waits) {
            REQUIRE(device_comes_to(pushes));
            REQUIRE(device_status()["boots"] > n_boots);  // no force without a new boot
        }
        usleep(after_us);
        const json before = device_status();
        n_boots = before["boots"];
        n_in_force += pushes(before) ? 1 : 0;
        fault("unplug at_s=0 for_s=" + out_s);
        REQUIRE(device_comes_to(at_rest));
    }
    REQUIRE(device_comes_to(pushes));
    CHECK(device_status()["homed"] == true);
    CHECK(n_in_force >= n / 2);  // most had a force: the test tests
    program.send(SIGTERM);
    CHECK(program.wait() == 0);
    std::ifstream in(said);
    const std::string words{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    CHECK(times_in(words, "The Falcon was unplugged") >= n / 2);
    CHECK(at_rest(device_status()));
    CHECK(device_status()["open"] == 0);
}

TEST_CASE("a loop that ends in order leaves zero force at once, not by the device's watchdog", "[process]") {
    const Folder folder;
    std::vector<std::string> options = hand(folder, "frames");
    options.insert(options.end(), {"--watchdog-ms", "100000"});
    const Bus bus(options);
    Process program(push(folder), Bus::environment());
    REQUIRE(device_comes_to(pushes));
    program.send(SIGTERM);
    CHECK(program.wait() == 0);
    CHECK(at_rest(device_status()));
    CHECK(device_status()["watchdog"] == false);
}

TEST_CASE("a loop that is killed under 8 N leaves the motors to the device's watchdog", "[process]") {
    const Folder folder;
    const Bus bus(hand(folder, "frames"));
    // Three words of 900 pull with 8 N or more along z between z = 75 and 175 mm, at the device's usual gain.
    Process program({usbtest::client("usb_push"), folder.firmware(), "900"}, Bus::environment());
    REQUIRE(device_comes_to([](const json& device) {
        return device["motor_counts"] == json::array({900, 900, 900});
    }));
    program.send(SIGKILL);
    CHECK(program.wait() == 128 + SIGKILL);
    CHECK(device_comes_to([](const json& device) { return device["open"] == 0 && at_rest(device); }));
    CHECK(device_status()["watchdog"] == true);
    Process next({falcon(), "boot", "--firmware", folder.firmware()}, Bus::environment());
    INFO(next.words());
    CHECK(next.wait() == 0);
}

TEST_CASE("a loop that stops ticking has its force taken away by its own watchdog", "[process]") {
    const Folder folder;
    std::vector<std::string> options = hand(folder, "frames");
    options.insert(options.end(), {"--watchdog-ms", "100000"});  // the device itself would push on
    const Bus bus(options);
    Process program(push(folder), Bus::environment());
    REQUIRE(device_comes_to(pushes));
    program.send(SIGUSR1);
    CHECK(device_comes_to(at_rest));
    const json then = device_status();
    CHECK(then["open"] == 1);
    CHECK(device_comes_to(
        [&](const json& device) { return device["requests"] > then["requests"]; }));  // it goes on
    CHECK(at_rest(device_status()));
}

TEST_CASE("a loop that is killed has its force taken away by its guard, long before the device's watchdog",
          "[process]") {
    const Folder folder;
    std::vector<std::string> options = hand(folder, "frames");
    options.insert(options.end(), {"--watchdog-ms", "100000"});
    const Bus bus(options);
    std::vector<std::string> argv = push(folder);
    argv.push_back(falcon());
    const bool in_order = GENERATE(as<bool>{}, false, true);
    Process program(argv, Bus::environment());
    REQUIRE(device_comes_to(pushes));
    program.send(in_order ? SIGTERM : SIGKILL);
    CHECK(program.wait() == (in_order ? 0 : 128 + SIGKILL));
    CHECK(device_comes_to([](const json& device) { return device["open"] == 0 && at_rest(device); }));
    CHECK(device_status()["watchdog"] == false);
    // The guard holds the other end of the output: it has ended, with words only when it was needed.
    CHECK((times_in(program.words(), "requests of zero force") == (in_order ? 0 : 1)));
}

TEST_CASE("a loop whose guard has died ends in order all the same", "[process]") {
    const Folder folder;
    const Bus bus(hand(folder, "immediate"));
    // In place of the guard a program that ends at once and reads nothing.
    std::vector<std::string> argv = push(folder);
    argv.emplace_back("/bin/true");
    Process program(argv, Bus::environment());
    REQUIRE(device_comes_to(pushes));
    program.send(SIGTERM);
    CHECK(program.wait() == 0);
    CHECK(at_rest(device_status()));
}

TEST_CASE("zero takes the force away from a Falcon whose program was killed, and boots nothing",
          "[process]") {
    const Folder folder;
    std::vector<std::string> options = hand(folder, "immediate");
    options.insert(options.end(), {"--watchdog-ms", "100000"});
    const Bus bus(options);
    Process program(push(folder), Bus::environment());
    REQUIRE(device_comes_to(pushes));
    program.send(SIGKILL);
    CHECK(program.wait() == 128 + SIGKILL);
    CHECK_FALSE(at_rest(device_status()));
    Process zero({falcon(), "zero"}, Bus::environment());
    CHECK(times_in(zero.words(), "requests of zero force") == 1);
    CHECK(zero.wait() == 0);
    CHECK(at_rest(device_status()));
    CHECK(device_status()["boots"] == 1);
}
