#include "sim/falcon/bridge.h"

#include <array>
#include <catch2/catch.hpp>
#include <vector>

namespace {

using Bytes = std::vector<uint8_t>;

pal_bridge fresh() {
    pal_bridge bridge{};
    pal_bridge_reset(&bridge, 0);
    return bridge;
}

int vendor(pal_bridge& bridge, uint8_t request, unsigned value, unsigned index = 0, uint64_t now_us = 0) {
    const uint8_t setup[8] = {0x40,
                              request,
                              static_cast<uint8_t>(value & 0xFFU),
                              static_cast<uint8_t>(value >> 8U),
                              static_cast<uint8_t>(index & 0xFFU),
                              static_cast<uint8_t>(index >> 8U),
                              0,
                              0};
    return pal_bridge_request(&bridge, now_us, setup, nullptr, 0);
}

Bytes ask(pal_bridge& bridge, uint8_t request, unsigned index, std::size_t length) {
    const uint8_t setup[8] = {
        0xC0, request, 0, 0, static_cast<uint8_t>(index), 0, static_cast<uint8_t>(length), 0};
    Bytes data(length);
    const int n = pal_bridge_request(&bridge, 0, setup, data.data(), data.size());
    data.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
    return data;
}

void receive(pal_bridge& bridge, const Bytes& bytes) {
    for (const uint8_t byte : bytes) pal_bridge_receive(&bridge, byte, true, 0);
}

Bytes in(pal_bridge& bridge, uint64_t now_us) {
    Bytes packet(PAL_BRIDGE_PACKET_BYTES);
    packet.resize(
        static_cast<std::size_t>(pal_bridge_in(&bridge, now_us, PAL_BRIDGE_PAYLOAD_BYTES, packet.data())));
    return packet;
}

/// All bytes that go on the line, as text.
Bytes sent(pal_bridge& bridge) {
    Bytes bytes;
    while (pal_bridge_sent_clock(&bridge) != UINT64_MAX) bytes.push_back(pal_bridge_sent(&bridge).byte);
    return bytes;
}

}  // namespace

TEST_CASE("each divisor word gives the bit time that the FT232R makes of it") {
    struct Row {
        uint16_t value, index;
        uint32_t clocks;  // of 24 MHz: 8 n + eighths
    };
    const Row row = GENERATE(as<Row>{}, Row{0x4138, 0, 2500}, Row{0x0015, 0, 168}, Row{0x0015, 1, 171},
                             Row{0x0002, 0, 16}, Row{0x001A, 0, 208}, Row{0xC034, 0, 417},
                             Row{0xC04E, 0, 625}, Row{0x0000, 0, 8}, Row{0x0001, 0, 12}, Row{0x8015, 0, 170},
                             Row{0x4015, 1, 173}, Row{0x8015, 1, 174}, Row{0xC015, 1, 175});
    CHECK(pal_bridge_divisor_clocks(row.value, row.index) == row.clocks);
}

TEST_CASE("a divisor that does not exist is refused and changes nothing") {
    pal_bridge bridge = fresh();
    CHECK(vendor(bridge, 0x03, 0x4001) == PAL_BRIDGE_STALL);
    CHECK(vendor(bridge, 0x03, 0x8000) == PAL_BRIDGE_STALL);
    CHECK(bridge.clocks_per_bit == 2500);
}

TEST_CASE("bytes leave at ten bits each, one behind the other, at the baud of the moment") {
    pal_bridge bridge = fresh();
    const Bytes request{0x0A, 0x43, 0x0D};
    REQUIRE(pal_bridge_out(&bridge, request.data(), 3, 100) == 3);
    for (int i = 0; i < 3; ++i) {
        CHECK(pal_bridge_sent_clock(&bridge) == 100U + 25000U * static_cast<unsigned>(i + 1));
        CHECK(pal_bridge_sent(&bridge).byte == request[static_cast<std::size_t>(i)]);
    }
    CHECK(pal_bridge_sent_clock(&bridge) == UINT64_MAX);
    vendor(bridge, 0x03, 0x0002);
    REQUIRE(pal_bridge_out(&bridge, request.data(), 1, 1000000) == 1);
    CHECK(pal_bridge_sent_clock(&bridge) == 1000160);
}

TEST_CASE(
    "the OUT buffer holds 128 bytes besides the one on the line, and takes a packet whole or not at all") {
    pal_bridge bridge = fresh();
    const Bytes packet(64, 0x55);
    CHECK(pal_bridge_out(&bridge, packet.data(), 64, 0) == 64);
    CHECK(pal_bridge_out(&bridge, packet.data(), 64, 0) == 64);
    CHECK(bridge.n_out == 127);
    CHECK(pal_bridge_out(&bridge, packet.data(), 2, 0) == 0);
    CHECK(pal_bridge_out(&bridge, packet.data(), 1, 0) == 1);
    CHECK(sent(bridge).size() == 129);
}

TEST_CASE("an idle IN token is refused until the latency timer ends, then gets two status bytes") {
    const unsigned ms = GENERATE(as<unsigned>{}, 1, 2, 16, 255);
    pal_bridge bridge = fresh();
    CHECK(bridge.latency_ms == 16);
    REQUIRE(vendor(bridge, 0x09, ms, 0, 5000) == 0);
    CHECK(ask(bridge, 0x0A, 0, 1) == Bytes{static_cast<uint8_t>(ms)});
    CHECK_FALSE(pal_bridge_in_ready(&bridge, 5000 + 1000U * ms - 1));
    CHECK(pal_bridge_in_ready(&bridge, 5000 + 1000U * ms));
    CHECK(in(bridge, 5000 + 1000U * ms) == Bytes{0x01, 0x60});
    CHECK_FALSE(pal_bridge_in_ready(&bridge, 5000 + 2000U * ms - 1));
    CHECK(pal_bridge_in_ready(&bridge, 5000 + 2000U * ms));
}

TEST_CASE("a latency of 0 or beyond 255 ms is refused") {
    pal_bridge bridge = fresh();
    CHECK(vendor(bridge, 0x09, 0) == PAL_BRIDGE_STALL);
    CHECK(vendor(bridge, 0x09, 256) == PAL_BRIDGE_STALL);
    CHECK(bridge.latency_ms == 16);
}

TEST_CASE("62 bytes go at once as one full packet, the two behind them wait for the timer") {
    pal_bridge bridge = fresh();
    receive(bridge, Bytes(61, 0xEE));
    CHECK_FALSE(pal_bridge_in_ready(&bridge, 0));
    receive(bridge, Bytes(3, 0xEE));
    CHECK(pal_bridge_in_ready(&bridge, 0));
    CHECK(in(bridge, 10).size() == 64);
    CHECK_FALSE(pal_bridge_in_ready(&bridge, 10 + 15999));
    CHECK(in(bridge, 10 + 16000) == Bytes{0x01, 0x60, 0xEE, 0xEE});
}

TEST_CASE("the event character sends what came up to it, but not when it came first") {
    pal_bridge bridge = fresh();
    REQUIRE(vendor(bridge, 0x06, 0x013E) == 0);
    receive(bridge, {'>'});
    CHECK_FALSE(pal_bridge_in_ready(&bridge, 0));
    receive(bridge, {'<'});
    CHECK_FALSE(pal_bridge_in_ready(&bridge, 0));
    receive(bridge, {'>'});
    CHECK(pal_bridge_in_ready(&bridge, 0));
    CHECK(in(bridge, 0) == Bytes{0x01, 0x60, '>', '<', '>'});
    REQUIRE(vendor(bridge, 0x06, 0x003E) == 0);
    receive(bridge, {'<', '>'});
    CHECK_FALSE(pal_bridge_in_ready(&bridge, 0));
}

TEST_CASE("what comes beyond 256 bytes is lost, and the next packet tells of the overrun once") {
    pal_bridge bridge = fresh();
    receive(bridge, Bytes(257, 0x11));
    CHECK(bridge.n_in == 256);
    CHECK(in(bridge, 0)[1] == 0x62);
    CHECK(in(bridge, 0)[1] == 0x60);
}

TEST_CASE("a framing error is told at once") {
    pal_bridge bridge = fresh();
    pal_bridge_receive(&bridge, 0x37, false, 0);
    CHECK(pal_bridge_in_ready(&bridge, 0));
    CHECK(in(bridge, 0) == Bytes{0x01, 0x68, 0x37});
    CHECK_FALSE(pal_bridge_in_ready(&bridge, 0));
}

TEST_CASE("the line status tells an empty holding register and an empty line apart") {
    pal_bridge bridge = fresh();
    bridge.modem_lines = 0x30;
    const Bytes two{1, 2};
    CHECK(ask(bridge, 0x05, 0, 2) == Bytes{0x31, 0x60});
    pal_bridge_out(&bridge, two.data(), 2, 0);
    CHECK(ask(bridge, 0x05, 0, 2) == Bytes{0x31, 0x00});
    static_cast<void>(pal_bridge_sent(&bridge));
    CHECK(ask(bridge, 0x05, 0, 2) == Bytes{0x31, 0x20});
    static_cast<void>(pal_bridge_sent(&bridge));
    CHECK(ask(bridge, 0x05, 0, 1) == Bytes{0x31});
}

TEST_CASE("a purge empties one direction, a reset both, and only the reset lowers DTR") {
    pal_bridge bridge = fresh();
    const Bytes three{1, 2, 3};
    const auto fill = [&] {
        pal_bridge_out(&bridge, three.data(), 3, 0);
        receive(bridge, three);
        vendor(bridge, 0x01, 0x0303);
        vendor(bridge, 0x03, 0x0015);
        vendor(bridge, 0x06, 0x013E);
    };
    fill();
    REQUIRE(vendor(bridge, 0x00, 1) == 0);  // host to device; the byte on the line goes on
    CHECK(bridge.n_out == 0);
    CHECK(bridge.busy);
    CHECK(bridge.n_in == 3);
    CHECK(bridge.dtr);
    REQUIRE(vendor(bridge, 0x00, 2) == 0);
    CHECK(bridge.n_in == 0);
    fill();
    REQUIRE(vendor(bridge, 0x00, 0) == 0);
    CHECK(bridge.n_in == 0);
    CHECK(bridge.n_out == 0);
    CHECK_FALSE(bridge.dtr);
    CHECK_FALSE(bridge.rts);
    CHECK_FALSE(bridge.event_on);
    CHECK(bridge.event == 0x0D);
    CHECK(bridge.clocks_per_bit == 168);  // baud and format are kept
    CHECK(vendor(bridge, 0x00, 3) == PAL_BRIDGE_STALL);
}

TEST_CASE("modem control changes the lines of its mask only") {
    pal_bridge bridge = fresh();
    vendor(bridge, 0x01, 0x0101);
    CHECK(bridge.dtr);
    CHECK_FALSE(bridge.rts);
    vendor(bridge, 0x01, 0x0202);
    CHECK(bridge.dtr);
    CHECK(bridge.rts);
    vendor(bridge, 0x01, 0x0100);
    CHECK_FALSE(bridge.dtr);
    CHECK(bridge.rts);
}

TEST_CASE("with RTS/CTS the bytes wait for CTS, with DTR/DSR for DSR, without for nothing") {
    pal_bridge bridge = fresh();
    const uint8_t byte = 0x42;
    vendor(bridge, 0x02, 0, 0x0100);
    pal_bridge_out(&bridge, &byte, 1, 0);
    CHECK(pal_bridge_sent_clock(&bridge) == UINT64_MAX);
    vendor(bridge, 0x02, 0, 0, 7);
    CHECK(pal_bridge_sent_clock(&bridge) == 7U * 24U + 25000U);
    bridge = fresh();
    bridge.modem_lines = 0x20;
    vendor(bridge, 0x02, 0, 0x0200);
    pal_bridge_out(&bridge, &byte, 1, 0);
    CHECK(pal_bridge_sent_clock(&bridge) == 25000);
}

TEST_CASE("XOFF from the line stops the bytes, XON lets them go, and neither reaches the host") {
    pal_bridge bridge = fresh();
    const Bytes two{1, 2};
    vendor(bridge, 0x02, 0x1311, 0x0400);
    receive(bridge, {0x13});
    pal_bridge_out(&bridge, two.data(), 2, 0);
    CHECK(pal_bridge_sent_clock(&bridge) == UINT64_MAX);
    pal_bridge_receive(&bridge, 0x11, true, 500);
    CHECK(pal_bridge_sent_clock(&bridge) == 25500);
    CHECK(bridge.n_in == 0);
}

TEST_CASE("bytes with another format than 8N1 are marked and take as many bits") {
    pal_bridge bridge = fresh();
    const uint8_t byte = 0x42;
    REQUIRE(vendor(bridge, 0x04, 0x1208) == 0);  // 8 bits, even parity, 2 stop bits
    pal_bridge_out(&bridge, &byte, 1, 0);
    CHECK(pal_bridge_sent_clock(&bridge) == 12U * 2500U);
    CHECK_FALSE(pal_bridge_sent(&bridge).frame_ok);
    REQUIRE(vendor(bridge, 0x04, 0x0008) == 0);
    pal_bridge_out(&bridge, &byte, 1, 0);
    CHECK(pal_bridge_sent(&bridge).frame_ok);
    CHECK(vendor(bridge, 0x04, 0x0005) == PAL_BRIDGE_STALL);
}

TEST_CASE("EEPROM words are read and written by address, and survive a power-on") {
    pal_bridge bridge = fresh();
    REQUIRE(vendor(bridge, 0x91, 0xBEEF, 60) == 0);
    pal_bridge_reset(&bridge, 0);
    CHECK(ask(bridge, 0x90, 60, 2) == Bytes{0xEF, 0xBE});
    CHECK(ask(bridge, 0x90, 64, 2) == Bytes{0xFF, 0xFF});
    CHECK(vendor(bridge, 0x91, 1, 64) == PAL_BRIDGE_STALL);
}

TEST_CASE("requests that the chip does not know are refused") {
    pal_bridge bridge = fresh();
    CHECK(vendor(bridge, 0x08, 0) == PAL_BRIDGE_STALL);
    CHECK(vendor(bridge, 0x0A, 0) == PAL_BRIDGE_STALL);
    CHECK(ask(bridge, 0x09, 0, 2).empty());
}
