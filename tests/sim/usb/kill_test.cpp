// The simulator or the device goes away in the middle of anything: a program must always come to an end with
// "no device", never wait for ever.
#include <cstdint>
#include <random>

#include "tests/sim/usb/process.hpp"

using namespace usbtest;

namespace {

constexpr int kLeft = 42, kNeverThere = 43;

TEST_CASE("whenever the simulator is killed, ended or the device unplugged, its programs end with no device",
          "[process][kill]") {
    const uint64_t seed = 20261128;
    const int n = soak() ? 500 : 10;
    const std::vector<std::string> modes = {"endless-sync", "endless-async", "endless-wait",
                                            "endless-threads"};
    std::mt19937_64 random(seed);
    int n_left = 0;
    for (int i = 0; i < n; ++i) {
        Bus bus({"--timing", random() % 2 == 0 ? "immediate" : "frames"});
        const std::string& mode = modes[random() % modes.size()];
        const uint64_t how = random() % 4;
        const int after_us = static_cast<int>(random() % 30000);
        CAPTURE(seed, i, mode, how, after_us);
        Process program({client("sim_usb_probe"), mode}, Bus::environment());
        usleep(static_cast<useconds_t>(after_us));
        if (how == 0) {
            CHECK(simulator({"fault", "unplug at_s=0 for_s=1000", "--bus", bus_folder()}).code == 0);
        } else {
            bus.process().send(how == 1 ? SIGTERM : SIGKILL);
        }
        const int code = program.wait();
        CHECK((code == kLeft || code == kNeverThere));
        n_left += code == kLeft;
    }
    CHECK(n_left > n / 2);  // most had the device in use: the test tests
}

TEST_CASE("whenever a program is killed, the next one finds the device free", "[process][kill]") {
    const uint64_t seed = 20261129;
    const int n = soak() ? 500 : 10;
    std::mt19937_64 random(seed);
    Bus bus({"--timing", "immediate"});
    const std::vector<std::string> modes = {"endless-sync", "endless-async", "endless-threads"};
    for (int i = 0; i < n; ++i) {
        const std::string& mode = modes[random() % modes.size()];
        const int after_us = static_cast<int>(random() % 15000);
        CAPTURE(seed, i, mode, after_us);
        Process program({client("sim_usb_probe"), mode}, Bus::environment());
        usleep(static_cast<useconds_t>(after_us));
        program.send(SIGKILL);
        CHECK(program.wait() == 128 + SIGKILL);
        Process next({client("sim_usb_plain"), "3"}, Bus::environment());
        CHECK(next.words() == "plain: 3 exchanges\n");
        CHECK(next.wait() == 0);
    }
}

}  // namespace
