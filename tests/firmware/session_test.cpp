#include "firmware/app/session.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <memory>
#include <vector>

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
    std::uint32_t n_ticks = 0;
    bool host_alive = true;

    Bench() {
        pal_link_init(link.get(), 1);
        link->host.enable = 1;
        const pal_device device = {&fake, collect, send};
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
        return pal_session_tick(session.get(), 1000000ULL * ++n_ticks, 0);
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
