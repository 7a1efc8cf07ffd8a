// What the tick of the real palpate-loop asks of the system: to sleep, and to move the device's packets.
#include <catch2/catch.hpp>
#include <cstring>
#include <ctime>
#include <set>

#include "tests/firmware/loop_host.hpp"
#include "tests/firmware/thread_trace.hpp"
#include "tests/firmware/usb_bench.hpp"
#include "tests/lacking.hpp"

using namespace loophost;
using threadtrace::calls_of;
using threadtrace::Counts;

namespace {

std::uint32_t n_ticks() {
    return usbtest::soak() ? 10000 : 1000;
}

/// The tick's thread, the loop's first, over n_ticks() ticks. nullopt: this machine lets nobody trace.
std::optional<Counts> calls_of_ticks(Host& host) {
    const auto thread = static_cast<pid_t>(pal_link_load(&host.link().loop.pid));
    const std::uint32_t first = pal_link_load(&host.link().loop.heartbeat);
    long n_stops = 0;
    auto counts = calls_of(thread, [&] {
        if (++n_stops % 32 == 0) host.look();
        return pal_link_load(&host.link().loop.heartbeat) - first < n_ticks();
    });
    if (!counts)
        palpate::test::lacking(std::string("the right to trace a child (ptrace): ") + std::strerror(errno));
    return counts;
}

/// Calls that are not in `allowed`, with their numbers.
std::string others(const Counts& counts, std::set<long> allowed) {
    allowed.insert(SYS_clock_gettime);  // a call only where the machine's clock cannot be read without
    std::string found;
    for (const auto& [call, n] : counts) {
        if (allowed.count(call) == 0)
            found += "call " + std::to_string(call) + " x " + std::to_string(n) + "; ";
    }
    return found;
}

}  // namespace

TEST_CASE("with a simulated device the tick sleeps, receives and sends, and calls nothing else",
          "[process]") {
    const Falcon falcon;
    Host host;
    host.offer_skin();
    Process loop(loophost::loop(host));
    REQUIRE(host.is_pressed());
    const auto counts = calls_of_ticks(host);
    if (!counts) return;
    CHECK(others(*counts, {SYS_clock_nanosleep, SYS_recvfrom, SYS_sendto}) == "");
    CHECK(counts->at(SYS_sendto) >= n_ticks() - 1);  // one in each
    CHECK(counts->at(SYS_sendto) <= n_ticks() + 1);
    pal_link_store(&host.link().host.stop, 1);
    CHECK(loop.wait() == 0);
}

TEST_CASE("with a Falcon on the USB the tick does what libusb needs, and calls nothing else", "[process]") {
    const usbbench::Folder folder;
    const usbtest::Bus bus({"--timing", "immediate", "--grip", "firm"});
    Host host;
    Process loop({usbtest::client("palpate-loop"), "--link", host.name(), "--device", "usb", "--firmware",
                  folder.firmware(), "--ramp-ticks", "20"},
                 usbtest::Bus::environment());
    REQUIRE(host.is_enabled());
    const auto counts = calls_of_ticks(host);
    if (!counts) return;
    // libusb: looks for what has ended, moves its timer, hands transfers over. In place of the kernel's usbfs
    // the simulator's preload answers these, over a socket.
    const std::set<long> libusb = {SYS_poll, SYS_timerfd_settime, SYS_ioctl};
    std::set<long> allowed = {SYS_clock_nanosleep, SYS_sendmsg,        SYS_recvfrom,
                              SYS_write,           SYS_rt_sigprocmask, SYS_rt_sigpending};
    allowed.insert(libusb.begin(), libusb.end());
    CHECK(others(*counts, allowed) == "");
    const auto times = [&](long call) { return counts->count(call) != 0 ? counts->at(call) : 0; };
    CHECK(times(SYS_write) <= times(SYS_rt_sigpending) + 1);  // the preload's writes come with one
    CHECK(times(SYS_rt_sigprocmask) <= 2 * times(SYS_rt_sigpending) + 2);
    pal_link_store(&host.link().host.stop, 1);
    CHECK(loop.wait() == 0);
}

TEST_CASE("one write in a hundred sleeps is seen", "[process]") {
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
        for (int n = 0;; ++n) {
            const timespec pause{0, 100000};
            clock_nanosleep(CLOCK_MONOTONIC, 0, &pause, nullptr);
            if (n % 100 == 99 && write(-1, "", 0) == 0) _exit(1);
        }
    }
    int n_stops = 0;
    const auto counts = calls_of(child, [&] { return ++n_stops < 1000; });
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    if (!counts) return palpate::test::lacking("the right to trace a child (ptrace)");
    CHECK(others(*counts, {SYS_clock_nanosleep}).find("call " + std::to_string(SYS_write) + " x ") == 0);
    CHECK(others(*counts, {SYS_clock_nanosleep, SYS_write}) == "");
}
