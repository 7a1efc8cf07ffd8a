// palpate-loop as a process: what it does when the segment, the system or another loop do not behave.
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <optional>
#include <thread>

#include "firmware/port/linux/device_socket.h"
#include "tests/firmware/loop_host.hpp"

using namespace loophost;
using Catch::Matchers::Contains;

namespace {

int end(Host& host, Process& loop) {
    pal_link_store(&host.link().host.stop, 1);
    return loop.wait();
}

std::vector<std::string> zero() {
    return {usbtest::client("palpate-loop"), "--zero", "--device", Falcon::device()};
}

/// Beats for the host that is busy otherwise.
class Heart {
public:
    explicit Heart(pal_link& link)
        : thread_([this, &link] {
              for (std::uint32_t beat = 1U << 31U; !stop_; ++beat) {
                  pal_link_store(&link.host.heartbeat, beat);
                  std::this_thread::sleep_for(std::chrono::milliseconds(20));
              }
          }) {}
    ~Heart() {
        stop_ = true;
        thread_.join();
    }
    Heart(const Heart&) = delete;
    Heart& operator=(const Heart&) = delete;

private:
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

}  // namespace

TEST_CASE("a truncated segment ends the loop with zero force and a sentence", "[process]") {
    // Gone altogether; all but the words; only the last page, which the records reach within four seconds.
    const auto n_left = GENERATE(as<off_t>{}, 0, 4096, static_cast<off_t>(sizeof(pal_link)) - 4096);
    const Falcon falcon;
    Host host;
    host.offer_skin();
    Process loop(loophost::loop(host));
    REQUIRE(host.is_pressed());
    REQUIRE_FALSE(Falcon::at_rest());
    if (n_left > 4096) {
        REQUIRE(host.until([&] { return pal_link_load(&host.link().loop.heartbeat) > 3000; }));
    }
    REQUIRE(ftruncate(host.file(), n_left) == 0);
    {
        std::optional<Heart> heart;
        if (n_left > 0) heart.emplace(host.link());  // its words are still there
        INFO(loop.words());
        CHECK(loop.wait() == 3);
    }
    CHECK_THAT(loop.so_far(), Contains("the shared segment was truncated"));
    CHECK(Falcon::at_rest());
    REQUIRE(ftruncate(host.file(), sizeof(pal_link)) == 0);
}

TEST_CASE("a segment has one loop at a time, and a new one after the first was killed", "[process]") {
    const Falcon falcon;
    Host host;
    host.offer_skin();
    Process first(loophost::loop(host));
    REQUIRE(host.is_pressed());
    const std::uint32_t holder = pal_link_load(&host.link().loop.pid);
    const usbtest::Outcome second = usbtest::call(loophost::loop(host));
    CHECK(second.code == 2);
    CHECK_THAT(second.words, Contains("it has a loop already, process " + std::to_string(holder)));
    CHECK(pal_link_load(&host.link().loop.ended) == 0);
    REQUIRE(host.is_pressed());  // the first goes on
    first.send(SIGKILL);
    CHECK(first.wait() == 128 + SIGKILL);
    pal_link_store(&host.link().loop.ended, 1);
    pal_link_store(&host.link().loop.end_reason, PAL_FAULT_HOST_LOST);
    pal_link_store(&host.link().loop.n_bad_tables, 3);
    // It may come before the device has seen the end of the first one's connection.
    CHECK(usbtest::call({usbtest::client("palpate-loop"), "--zero", "--device", Falcon::device()}).code == 0);
    Process third(loophost::loop(host));
    REQUIRE(host.until([&] {
        return pal_link_load(&host.link().loop.pid) != holder && host.newest().tick > 0 &&
               host.newest().tick < 5000 && pal_link_load(&host.link().loop.ended) == 0;
    }));
    REQUIRE(host.is_pressed());
    CHECK(pal_link_load(&host.link().loop.end_reason) == 0);
    CHECK(pal_link_load(&host.link().loop.n_bad_tables) == 0);
    CHECK(end(host, third) == 0);
    CHECK(pal_link_load(&host.link().loop.ended) == 1);
    CHECK(Falcon::at_rest());
}

TEST_CASE("a killed loop's force is taken away by --zero, which says nothing", "[process]") {
    const Falcon falcon;
    Host host;
    host.offer_skin();
    Process loop(loophost::loop(host));
    REQUIRE(host.is_pressed());
    loop.send(SIGKILL);
    CHECK(loop.wait() == 128 + SIGKILL);
    const usbtest::Outcome outcome = usbtest::call(zero());
    CHECK(outcome.code == 0);
    CHECK(outcome.words.empty());
    CHECK(Falcon::at_rest());  // two seconds before its own watchdog
    CHECK(Falcon::status()["watchdog"] == false);
}

TEST_CASE("--zero gives up on a device that another program holds", "[process]") {
    const Falcon falcon;
    pal_device_socket socket;
    pal_device device;
    REQUIRE(pal_device_socket_open(&socket, Falcon::socket().c_str(), &device) == PAL_OK);
    const usbtest::Outcome held = usbtest::call(zero());
    CHECK(held.code == 3);
    CHECK_THAT(held.words, Contains("another program holds the device"));
    pal_device_socket_close(&socket);
    CHECK(usbtest::call(zero()).code == 0);
}

TEST_CASE("--zero says when there is no device", "[process]") {
    const usbtest::Outcome outcome =
        usbtest::call({usbtest::client("palpate-loop"), "--zero", "--device", "link:/tmp/pal-nobody"});
    CHECK(outcome.code == 3);
    CHECK_THAT(outcome.words, Contains("link:/tmp/pal-nobody: No such file"));
}

TEST_CASE("a stopped and continued loop comes back without force, and with the ramp", "[process]") {
    const Falcon falcon;
    Host host;
    host.offer_skin();
    Process loop(loophost::loop(host, {"--ramp-ticks", "100"}));
    REQUIRE(host.is_pressed());
    host.keep(true);
    REQUIRE(host.until([&] { return !host.kept().empty(); }));
    loop.send(SIGSTOP);
    host.look();
    poll(nullptr, 0, 100);
    loop.send(SIGCONT);
    // The first tick after the stall: it knows what it missed.
    const auto stalled = [&] {
        for (std::size_t i = 1; i < host.kept().size(); ++i) {
            if (host.kept()[i].n_missed - host.kept()[i - 1].n_missed >= 20) return i;
        }
        return std::size_t{0};
    };
    REQUIRE(host.until([&] { return stalled() > 0; }));
    const std::uint32_t first = host.kept()[stalled()].tick;
    REQUIRE(host.until([&] { return host.newest().tick > first + 400; }));
    REQUIRE(host.is_pressed());
    CHECK(end(host, loop) == 0);
    double last_n = 0.0;
    for (const pal_tick& tick : host.kept()) {
        if (tick.tick < first) continue;
        if (tick.tick == first) CHECK(tick.stop == PAL_FAULT_DEVICE_LOST);
        if (tick.state == PAL_STATE_FAULT) {
            for (const std::int16_t motor : tick.motor_counts) CHECK(motor == 0);
        }
        const double force_n = static_cast<double>(tick.force_n[2]);
        CHECK(force_n < last_n + 0.3);  // 3.2 N over 100 ticks is 0.03 N each; a jump would be all of it
        last_n = force_n;
    }
}

TEST_CASE("Ctrl-Z and a closed output leave the loop running", "[process]") {
    const Falcon falcon;
    Host host;
    Process loop(loophost::loop(host));
    REQUIRE(host.comes_to(PAL_STATE_ENABLED));
    loop.send(SIGTSTP);
    loop.send(SIGPIPE);
    const std::uint32_t then = host.newest().tick;
    CHECK(host.until([&] { return host.newest().tick > then + 100; }));
    CHECK(end(host, loop) == 0);
}

TEST_CASE("signals end the loop with zero force and their own exit code", "[process]") {
    const auto [number, code] = GENERATE(table<int, int>({{SIGINT, 130}, {SIGTERM, 0}, {SIGHUP, 0}}));
    const Falcon falcon;
    Host host;
    host.offer_skin();
    Process loop(loophost::loop(host));
    REQUIRE(host.is_pressed());
    loop.send(number);
    CHECK(loop.wait() == code);
    CHECK(Falcon::at_rest());
    CHECK(pal_link_load(&host.link().loop.ended) == 1);
}
