#include "tests/firmware/falcon_running.hpp"

using namespace script;

TEST_CASE("requests come once a period and never before the reply to the one before") {
    Running s;
    std::vector<std::uint64_t> times;
    std::size_t n_open = 0;
    s.device.tamper = [&](std::size_t, const Bytes&, Bytes&) {
        times.push_back(s.now_us);
        n_open = s.falcon.exchange.n_requests - s.falcon.exchange.n_replies - s.falcon.exchange.n_timeouts;
        CHECK(n_open == 1);
    };
    REQUIRE(s.exchange(100));
    for (std::size_t k = 2; k < times.size(); ++k) CHECK(times[k] - times[k - 1] == 1000);
    s.device.answer_us = 2500;  // slower than the period: as it answers
    REQUIRE(s.exchange(100));
    for (std::size_t k = times.size() - 50; k < times.size(); ++k) CHECK(times[k] - times[k - 1] == 2500);
}

TEST_CASE("replies cut anywhere, with status-only packets between, are whole replies") {
    const std::size_t cut = GENERATE(range(std::size_t{1}, std::size_t{16}));
    Running s(Running::no_ramp());
    s.device.cuts = {cut, 16 - cut};
    s.device.status_between = true;
    REQUIRE(s.exchange(50));
    CHECK(s.sense().n_timeouts == 0);
    CHECK(s.sense().n_skipped_bytes == 0);
    CHECK_FALSE(is_zero(s.last()));
}

TEST_CASE("after junk at any byte of a reply, in place of one or between, the second exchange is good") {
    const int how = GENERATE(range(0, 4));
    for (std::size_t at = 0; at < 16; ++at) {
        Running s(Running::no_ramp());
        REQUIRE(s.exchange(20));
        const std::size_t n_writes = s.device.n_writes;
        s.device.tamper = [&](std::size_t k, const Bytes&, Bytes& said) {
            if (k != n_writes) return;
            const auto place = said.begin() + static_cast<std::ptrdiff_t>(at);
            if (how == 0) said.erase(place);
            if (how == 1) said.insert(place, 0x7F);
            if (how == 2) said.insert(place, '<');
            if (how == 3) *place = 0xFE;
        };
        const std::uint32_t n_replies = s.sense().n_exchanges;
        REQUIRE(s.exchange(1));
        // The spoilt one may be lost, and 0xFE as a flag byte is refused; the one after it may not.
        REQUIRE(s.device.n_writes - n_writes <= 2);
        REQUIRE(s.sense().n_exchanges == n_replies + 1);
        REQUIRE(s.exchange(5));
        REQUIRE(s.falcon.state == PAL_FALCON_READY);
        REQUIRE(s.sense().position_m[2] == Approx(0.11).margin(2.5e-5));
    }
}

TEST_CASE("after a reply that did not come the bridge is purged, what comes is drained, the force is zero") {
    Running s(Running::no_ramp());
    REQUIRE(s.exchange(20));
    REQUIRE_FALSE(is_zero(s.last()));
    const std::size_t n_writes = s.device.n_writes;
    const std::size_t n_log = s.device.log.size();
    s.device.tamper = [&](std::size_t k, const Bytes&, Bytes& said) {
        if (k != n_writes) return;
        said.clear();  // it comes after the purge: a stale reply with another position
        s.device.say(reply({0, 0, 0}, HOMED), s.now_us + 21500);
    };
    std::uint64_t asked_us = 0;
    while (s.device.n_writes <= n_writes) {
        asked_us = s.now_us;
        s.step();
    }
    const std::uint64_t purge_us = asked_us + s.transfer_us + 20000;
    REQUIRE(s.exchange(1));
    const Lines log(s.device.log.begin() + static_cast<std::ptrdiff_t>(n_log) + 1, s.device.log.end());
    CHECK(log == Lines{"C 00 0001 0000", "C 00 0002 0000",
                       "W 3C414141414141414141414141"
                       "46"
                       "413E"});
    CHECK(s.now_us >= purge_us + 2 * s.transfer_us + 5000);
    CHECK(s.sense().encoder_counts[0] == -516);  // not the stale one
    CHECK((s.sense().faults & PAL_FALCON_TIMEOUT) != 0);
    CHECK(s.sense().n_timeouts == 1);
    REQUIRE(s.exchange(3));
    CHECK_FALSE(is_zero(s.last()));
    CHECK((s.sense().faults & PAL_FALCON_TIMEOUT) == 0);
    CHECK((s.sense().faults_seen & PAL_FALCON_TIMEOUT) != 0);
}

TEST_CASE("two replies at once: the later counts, and the bridge is purged before the next request") {
    Running s(Running::no_ramp());
    REQUIRE(s.exchange(20));
    const std::size_t n_writes = s.device.n_writes;
    s.device.tamper = [&](std::size_t k, const Bytes&, Bytes& said) {
        if (k != n_writes) return;
        const Bytes newer = reply({-500, -516, -516}, HOMED);
        said.insert(said.end(), newer.begin(), newer.end());
    };
    const std::size_t n_log = s.device.log.size();
    REQUIRE(s.exchange(1));
    CHECK(s.sense().encoder_counts[0] == -500);
    CHECK(s.sense().n_unasked == 1);
    CHECK((s.sense().faults_seen & PAL_FALCON_UNASKED) != 0);
    REQUIRE(s.exchange(1));
    CHECK(
        lines({s.device.log.begin() + static_cast<std::ptrdiff_t>(n_log), s.device.log.end()}, "C").size() ==
        2);
}

TEST_CASE("a device that falls silent is a named fault, with zero force in every request from then on") {
    Running s(Running::no_ramp());
    REQUIRE(s.exchange(20));
    REQUIRE_FALSE(is_zero(s.last()));
    const std::size_t n_before = lines(s.device.log, "W").size();
    s.device.dsp = Dsp::mute;
    const std::uint64_t began_us = s.now_us;
    REQUIRE(s.run([&] {
        s.drive();
        return s.falcon.state == PAL_FALCON_FAULT;
    }));
    CHECK(s.now_us - began_us <= 10 * (20000 + 5000 + 1000 + 3 * s.transfer_us));
    CHECK(s.status().failure == PAL_FAIL_SILENT);
    CHECK(s.status().at_stage == PAL_STAGE_READY);
    REQUIRE(s.run([&] { return pal_falcon_done(&s.falcon); }, 1000000));
    const Lines writes = lines(s.device.log, "W");
    for (std::size_t k = n_before + 1; k < writes.size(); ++k) REQUIRE(is_zero(words_of(writes[k])));
    for (std::size_t k = writes.size() - 5; k < writes.size(); ++k) CHECK(writes[k] == ZERO_FORCE);
    const std::size_t n_log = s.device.log.size();
    for (int k = 0; k < 100; ++k) s.step();
    CHECK(s.device.log.size() == n_log);
}

TEST_CASE("stopping sends zero force five times and then nothing, whether the device answers or not") {
    const bool answers = GENERATE(true, false);
    Running s(Running::no_ramp());
    REQUIRE(s.exchange(20));
    REQUIRE_FALSE(is_zero(s.last()));
    if (!answers) s.device.dsp = Dsp::mute;
    const std::size_t n_before = lines(s.device.log, "W").size();
    pal_falcon_stop(&s.falcon);
    s.drive();
    REQUIRE(s.run_to(PAL_FALCON_CLOSED, 200000));
    CHECK(pal_falcon_done(&s.falcon));
    const Lines writes = lines(s.device.log, "W");
    REQUIRE(writes.size() == n_before + 5);
    for (std::size_t k = n_before; k < writes.size(); ++k) CHECK(writes[k] == ZERO_FORCE);
    for (int k = 0; k < 100; ++k) s.step();
    CHECK(lines(s.device.log, "W").size() == n_before + 5);
}

TEST_CASE("a port whose transfers all fail comes to an end in every state") {
    const int when = GENERATE(range(0, 3));
    Running s(Running::no_ramp());
    if (when > 0) REQUIRE(s.exchange(20));
    if (when == 2) pal_falcon_stop(&s.falcon);
    for (int k = 0; k < 2000 && !pal_falcon_done(&s.falcon); ++k) {
        const pal_usb_step step = pal_falcon_next(&s.falcon, s.now_us);
        s.now_us += step.kind == PAL_USB_IDLE ? step.wake_us : 100;
        if (step.kind != PAL_USB_IDLE) pal_falcon_transfer_failed(&s.falcon, false, s.now_us);
    }
    CHECK(pal_falcon_done(&s.falcon));
    CHECK(s.falcon.state == PAL_FALCON_FAULT);
}

TEST_CASE("a line error that the bridge reports is a fault of that exchange") {
    Running s;
    REQUIRE(s.exchange(10));
    const Bytes overrun{0x01, 0x62};
    pal_falcon_feed(&s.falcon, overrun.data(), overrun.size(), s.now_us);
    CHECK((s.sense().faults & PAL_FALCON_LINE) != 0);
    REQUIRE(s.exchange(2));
    CHECK((s.sense().faults & PAL_FALCON_LINE) == 0);
    CHECK((s.sense().faults_seen & PAL_FALCON_LINE) != 0);
}

TEST_CASE("a clock that goes back or leaps does no harm") {
    Running s(Running::no_ramp());
    REQUIRE(s.exchange(20));
    s.now_us -= 500000;
    const pal_usb_step step = pal_falcon_next(&s.falcon, s.now_us);
    CHECK((step.kind != PAL_USB_IDLE || step.wake_us <= 20000));
    s.now_us += std::uint64_t{1} << 40U;
    REQUIRE(s.exchange(20));
    CHECK(s.falcon.state == PAL_FALCON_READY);
}
