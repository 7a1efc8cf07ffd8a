// The fault slow-host: a host too busy for bulk transfers.
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "tests/sim/faulty_host.hpp"

using namespace palpate::test;

TEST_CASE(
    "a slow host moves no bulk transfer for its time, while the device goes on, and then all is there") {
    PlainHost host = running();
    inject(host, "slow-host at_s=0.01 for_s=0.05");
    host.advance_to(9900);
    CHECK(host.out(bytes_of("<AAABAAABAAABAA>")) == 16);
    host.advance_to(10000);
    Bytes packet;
    CHECK(host.in(packet) == 0);
    CHECK(host.out(ZERO_REQUEST) == 0);
    CHECK(pal_usb_device_next_us(host.device()) == 60000);
    host.advance_to(59999);
    CHECK(pal_usb_device_present(host.device()));
    CHECK(host.truth().n_replies == 1);
    CHECK(host.truth().motor_counts[0] == 4095);
    CHECK(host.in(packet) == 0);
    CHECK(host.out(ZERO_REQUEST) == 0);
    CHECK(host.ask(0xC0, 0x0A, 0, 0, 1) == Bytes{1});  // control transfers pass
    CHECK(pal_usb_device_next_us(host.device()) == 60000);
    const auto late = host.read();
    REQUIRE(late);
    CHECK(late->at_us == 60000);
    CHECK(late->bytes.size() == 18);
    CHECK(exchange(host).size() == 16);
    CHECK(host.truth().n_requests == 2);
    CHECK(host.truth().n_strikes == 1);
}

TEST_CASE("a slow host of more than the watchdog's time finds the motors off") {
    PlainHost host = running();
    host.out(bytes_of("<AAABAAABAAABAA>"));
    static_cast<void>(host.payload(16));
    inject(host, "slow-host for_s=0.15");
    host.wait(90000);
    CHECK_FALSE(host.truth().watchdog);
    host.wait(20000);
    CHECK(host.truth().watchdog);
    CHECK(host.truth().motor_counts[0] == 0);
    host.wait(40000);
    host.purge();
    CHECK(exchange(host).size() == 16);
}

TEST_CASE("a slow host comes back at its pace, as often as it says, and a halt is seen only between") {
    const std::string n = GENERATE(as<std::string>{}, "1", "3", "");
    const uint64_t n_times = n.empty() ? 1000 : std::stoull(n);
    PlainHost host = running();
    inject(host, "stall ep=out at_s=0.01");
    inject(host, "slow-host at_s=0.01 for_s=0.002 every_s=0.007" + (n.empty() ? n : " n=" + n));
    for (uint64_t at_us = 10000; at_us < 100000; at_us += 500) {
        host.advance_to(at_us);
        const uint64_t since_us = at_us - 10000;
        const bool slow = since_us / 7000 < n_times && since_us % 7000 < 2000;
        CAPTURE(at_us);
        REQUIRE(host.out({'x'}) == (slow ? 0 : PAL_USB_STALL));
    }
    CHECK(host.truth().n_strikes == 1 + std::min<uint64_t>(n_times, 13));
    pal_usb_device_heal(host.device());
    host.advance_to(108500);  // the 15th would have begun at 108000
    CHECK(host.out({'x'}) == 1);
}
