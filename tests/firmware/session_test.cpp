#include "firmware/app/session.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <memory>
#include <vector>

#include "firmware/app/warm.h"
#include "firmware/falcon/wire.h"
#include "tests/common/tables.hpp"

namespace {

/// A device of bytes: answers each tick with what it is told to, keeps what it got.
struct FakeDevice {
    std::array<std::uint8_t, 16> reply{};
    pal_device_news news = PAL_DEVICE_FRESH;
    std::vector<std::array<std::uint8_t, 16>> requests;
};

pal_device_news collect(void* context, std::uint8_t reply[16]) {
    const auto* device = static_cast<FakeDevice*>(context);
    if (device->news == PAL_DEVICE_FRESH) std::memcpy(reply, device->reply.data(), 16);
    return device->news;
}

pal_device_news send(void* context, const std::uint8_t request[16]) {
    auto* device = static_cast<FakeDevice*>(context);
    std::array<std::uint8_t, 16> packet;
    std::memcpy(packet.data(), request, 16);
    device->requests.push_back(packet);
    return device->news == PAL_DEVICE_GONE ? PAL_DEVICE_GONE : PAL_DEVICE_FRESH;
}

std::uint64_t no_time() {
    return 5;
}

struct Bench {
    std::unique_ptr<pal_link> link = std::make_unique<pal_link>();
    FakeDevice fake;
    std::unique_ptr<pal_session> session = std::make_unique<pal_session>();
    std::uint32_t n_ticks = 0, n_missed = 0;
    bool host_alive = true;

    Bench() {
        pal_link_init(link.get(), 1);
        link->host.enable = 1;
        const pal_device device = {&fake, collect, send, nullptr};
        pal_loop_config config = pal_loop_config_default();
        config.ramp_ticks = 0;
        pal_session_begin(session.get(), link.get(), &device, &config, no_time);
        const auto table = tables::make();
        std::memcpy(pal_table_ring_back(&link->tables), table.get(), sizeof(pal_table));
        pal_table_ring_publish(&link->tables);
        pal_drive counts{};  // a reply from 3 mm inside the skin
        const float at[3] = {0.0F, 0.0F, 0.117F};
        float theta[3];
        pal_delta_inverse(&PAL_DELTA_NF1, at, theta);
        for (int i = 0; i < 3; ++i) pal_delta_counts(&PAL_DELTA_NF1, theta[i], &counts.motor_counts[i]);
        pal_wire_encode(&counts, fake.reply.data());
        fake.reply[13] = 0x41 + 0x70;
    }
    pal_session_end tick() {
        if (host_alive) link->host.heartbeat += 1;
        pal_intake_check(&session->intake);
        const pal_session_time now{1000000ULL * ++n_ticks, n_missed, 0};
        return pal_session_tick(session.get(), &now);
    }
    [[nodiscard]] bool last_request_is_zero() const {
        for (std::size_t i = 1; i <= 12; ++i) {
            if (fake.requests.back()[i] != 0x41) return false;
        }
        return true;
    }
};

}  // namespace

TEST_CASE("a session presses against the table and records every tick") {
    Bench bench;
    for (int n = 0; n < 10; ++n) CHECK(bench.tick() == PAL_SESSION_RUNS);
    CHECK_FALSE(bench.last_request_is_zero());
    pal_state_reader reader{};
    pal_tick record;
    for (std::uint32_t n = 0; n < 10; ++n) {
        REQUIRE(pal_state_ring_read(&bench.link->ticks, &reader, &record));
        CHECK(record.tick == n);
        CHECK(record.t_ns == 1000000ULL * (n + 1));
        CHECK(record.stamp_ns[4] == 5);
    }
    CHECK(record.depth_m > 2.9e-3F);
    CHECK(bench.link->loop.heartbeat == 9);
}

TEST_CASE("a host that falls silent for 500 ticks is lost: zero force and an end") {
    Bench bench;
    for (int n = 0; n < 10; ++n) bench.tick();
    bench.host_alive = false;
    for (int n = 0; n < 499; ++n) REQUIRE(bench.tick() == PAL_SESSION_RUNS);
    CHECK(bench.tick() == PAL_SESSION_HOST_LOST);
    CHECK(bench.last_request_is_zero());
    pal_session_finish(bench.session.get(), PAL_SESSION_HOST_LOST);
    CHECK(bench.link->loop.ended == 1);
    CHECK(bench.link->loop.end_reason == PAL_FAULT_HOST_LOST);
}

TEST_CASE("a host process that is gone is lost in the same tick") {
    Bench bench;
    for (int n = 0; n < 10; ++n) bench.tick();
    bench.session->host_gone = 1;
    CHECK(bench.tick() == PAL_SESSION_HOST_LOST);
    CHECK(bench.last_request_is_zero());
}

TEST_CASE("the stop word and a signal end the session, a closed device too") {
    Bench asked;
    asked.link->host.stop = 1;
    CHECK(asked.tick() == PAL_SESSION_ASKED);
    Bench signalled;
    signalled.session->asked = 1;
    CHECK(signalled.tick() == PAL_SESSION_ASKED);
    Bench gone;
    gone.fake.news = PAL_DEVICE_GONE;
    CHECK(gone.tick() == PAL_SESSION_DEVICE_GONE);
    pal_session_finish(gone.session.get(), PAL_SESSION_DEVICE_GONE);
    CHECK(gone.link->loop.end_reason == PAL_FAULT_DEVICE_LOST);
}

TEST_CASE("the operator's words act in the same tick") {
    Bench bench;
    for (int n = 0; n < 10; ++n) bench.tick();
    bench.link->host.enable = 0;
    bench.tick();
    CHECK(bench.last_request_is_zero());
    bench.link->host.enable = 1;
    bench.tick();
    CHECK_FALSE(bench.last_request_is_zero());
    bench.link->host.estop = 1;
    bench.tick();
    CHECK(bench.last_request_is_zero());
    bench.link->host.estop = 0;
    bench.tick();
    CHECK(bench.last_request_is_zero());
}

TEST_CASE("replies that are no packets count as none") {
    Bench bench;
    for (int n = 0; n < 10; ++n) bench.tick();
    bench.fake.reply[5] = 0x20;
    for (int n = 0; n < 20; ++n) bench.tick();
    CHECK(bench.session->loop.stop == PAL_FAULT_DEVICE_LOST);
    CHECK(bench.last_request_is_zero());
}

TEST_CASE("the zero packet is all A") {
    Bench bench;
    pal_session_send_zero(bench.session.get());
    CHECK(std::memcmp(bench.fake.requests.back().data(), "<AAAAAAAAAAAAAA>", 16) == 0);
}

namespace {

std::uint64_t clock_ns = 0;

/// Each look at the clock takes 1 us.
std::uint64_t counting_clock() {
    return clock_ns += 1000;
}

/// A device with a wire of its own: a reply came at 100, a request is handed over at 7000 and out at 9000.
void wire_times(void* /*context*/, pal_device_times* times) {
    *times = {100, 7000, 9000};
}

pal_tick newest(const pal_link& link) {
    pal_state_reader reader{.next = link.ticks.done - 1U, .n_dropped = 0};
    pal_tick record{};
    REQUIRE(pal_state_ring_read(&link.ticks, &reader, &record));
    return record;
}

}  // namespace

TEST_CASE("a tick's stamps say when each thing happened, in order") {
    Bench bench;
    bench.session->now_ns = counting_clock;
    clock_ns = 1000000;
    bench.tick();
    const pal_tick tick = newest(*bench.link);
    CHECK(tick.stamp_ns[0] == 1001000);  // the reply is read
    CHECK(tick.stamp_ns[1] == 1000000);
    CHECK(tick.stamp_ns[2] == 1002000);
    CHECK(tick.stamp_ns[3] == 1003000);
    CHECK(tick.stamp_ns[4] == 1004000);
    CHECK(tick.stamp_ns[5] == tick.stamp_ns[4]);  // a socket is done when it has taken it
}

TEST_CASE("without a reply and without a request there are no stamps of them, and the last end stays") {
    Bench bench;
    bench.session->now_ns = counting_clock;
    clock_ns = 1000000;
    bench.tick();
    const std::uint64_t done_ns = newest(*bench.link).stamp_ns[5];
    bench.session->device.send = [](void*, const std::uint8_t*) { return PAL_DEVICE_NONE; };
    bench.fake.news = PAL_DEVICE_NONE;
    clock_ns = 2000000;
    bench.tick();
    const pal_tick tick = newest(*bench.link);
    CHECK(tick.stamp_ns[0] == 0);
    CHECK(tick.stamp_ns[4] == 0);
    CHECK(tick.stamp_ns[5] == done_ns);
}

TEST_CASE("a device that knows when its packets passed is believed") {
    Bench bench;
    bench.session->device.times = wire_times;
    bench.tick();
    const pal_tick tick = newest(*bench.link);
    CHECK(tick.stamp_ns[0] == 100);
    CHECK(tick.stamp_ns[4] == 7000);
    CHECK(tick.stamp_ns[5] == 9000);
}

TEST_CASE("the record has the tick's lateness and all missed periods; the loop only the new ones") {
    Bench bench;
    for (int n = 0; n < 10; ++n) bench.tick();
    bench.n_missed = 3;
    const pal_session_time late{99, 3, 42};
    CHECK(pal_session_tick(bench.session.get(), &late) == PAL_SESSION_RUNS);
    CHECK(newest(*bench.link).n_missed == 3);
    CHECK(newest(*bench.link).wake_late_ns == 42);
    for (std::uint32_t n = 4; n < 40; ++n) {  // one more in each tick is never twenty
        bench.n_missed = n;
        bench.tick();
        CHECK(newest(*bench.link).stop == 0);
        CHECK_FALSE(bench.last_request_is_zero());
    }
    bench.n_missed = 39 + 20;
    bench.tick();
    CHECK(newest(*bench.link).stop == PAL_FAULT_DEVICE_LOST);
    CHECK(bench.last_request_is_zero());
}

TEST_CASE("the count of missed periods may wrap") {
    Bench bench;
    bench.session->n_missed_seen = bench.n_missed = 0xFFFFFFFEU;
    for (int n = 0; n < 10; ++n) bench.tick();
    bench.n_missed = 2;  // four more
    bench.tick();
    CHECK(newest(*bench.link).stop == 0);
    CHECK_FALSE(bench.last_request_is_zero());
    bench.n_missed = 22;
    bench.tick();
    CHECK(newest(*bench.link).stop == PAL_FAULT_DEVICE_LOST);
}

TEST_CASE("a tick that was stopped in its middle sends zero") {
    const auto stall_ns = GENERATE(as<std::uint64_t>{}, 4999999, 5000000, 1000000000);
    Bench bench;
    for (int n = 0; n < 10; ++n) bench.tick();
    static std::uint64_t late_ns = 0;
    late_ns = 1000000ULL * 11 + stall_ns;
    bench.session->now_ns = [] { return late_ns; };
    bench.tick();
    const bool old = stall_ns >= 5000000;
    CHECK(bench.last_request_is_zero() == old);
    const pal_tick tick = newest(*bench.link);
    CHECK(((tick.faults & PAL_FAULT_LATE) != 0) == old);
    CHECK((tick.motor_counts[0] == 0) == old);
    CHECK((tick.force_n[2] == 0.0F) == old);
}

TEST_CASE("a segment that is gone is zero force and an end in the same tick") {
    Bench bench;
    for (int n = 0; n < 10; ++n) bench.tick();
    bench.session->segment_gone = 1;
    CHECK(bench.tick() == PAL_SESSION_SEGMENT_GONE);
    CHECK(bench.last_request_is_zero());
}

TEST_CASE("the ticks that warm up feel the skin that they are shown, with one table and with two") {
    const pal_loop_config config = pal_loop_config_default();
    CHECK(pal_warm_loop(&config) == PAL_WARM_TICKS);
}
