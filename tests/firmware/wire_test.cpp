#include "firmware/falcon/wire.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <vector>

namespace {

using Packet = std::array<std::uint8_t, PAL_WIRE_BYTES>;

Packet encode(std::array<std::int16_t, 3> motors, std::uint8_t homing, std::uint8_t leds) {
    pal_drive drive{};
    for (std::size_t i = 0; i < 3; ++i) drive.motor_counts[i] = motors[i];
    drive.homing = homing;
    drive.leds = leds;
    Packet packet;
    pal_wire_encode(&drive, packet.data());
    return packet;
}

}  // namespace

TEST_CASE("requests have the bytes of the protocol's worked examples") {
    CHECK(encode({0, 0, 0}, 0, 0) == Packet{0x3C, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41,
                                            0x41, 0x41, 0x41, 0x41, 0x3E});
    CHECK(encode({1000, -1000, 4095}, 0, 4) == Packet{0x3C, 0x49, 0x4F, 0x44, 0x41, 0x49, 0x42, 0x4D, 0x50,
                                                      0x50, 0x50, 0x50, 0x41, 0x45, 0x41, 0x3E});
    CHECK(encode({-4095, 4095, -1}, 0, 8) == Packet{0x3C, 0x42, 0x41, 0x41, 0x50, 0x50, 0x50, 0x50, 0x41,
                                                    0x50, 0x50, 0x50, 0x50, 0x49, 0x41, 0x3E});
    CHECK(encode({0, 0, 0}, 1, 8) == Packet{0x3C, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41,
                                            0x41, 0x41, 0x4A, 0x41, 0x3E});
    CHECK(encode({32767, -32768, 0}, 0, 0) == Packet{0x3C, 0x50, 0x50, 0x50, 0x48, 0x41, 0x41, 0x41, 0x49,
                                                     0x41, 0x41, 0x41, 0x41, 0x41, 0x41, 0x3E});
}

TEST_CASE("a request that was captured from a real host is reproduced byte by byte") {
    CHECK(encode({2752, 2780, 2888}, 0, 4) == Packet{0x3C, 0x41, 0x4D, 0x4B, 0x41, 0x4D, 0x4E, 0x4B, 0x41,
                                                     0x49, 0x45, 0x4C, 0x41, 0x45, 0x41, 0x3E});
}

TEST_CASE("replies give encoders, buttons and homed flags") {
    pal_sense sense{};
    sense.enable = 1;
    const Packet homed = {0x3C, 0x4A, 0x46, 0x4B, 0x50, 0x41, 0x41, 0x41,
                          0x41, 0x42, 0x41, 0x41, 0x41, 0xB1, 0x41, 0x3E};
    REQUIRE(pal_wire_decode(homed.data(), &sense));
    CHECK(sense.encoder_counts[0] == -1447);
    CHECK(sense.encoder_counts[1] == 0);
    CHECK(sense.encoder_counts[2] == 1);
    CHECK(sense.homed == 7);
    CHECK(sense.buttons == 0);
    CHECK(sense.fresh == 1);
    CHECK(sense.enable == 1);
    Packet all = homed;
    all[13] = 0xC0;
    REQUIRE(pal_wire_decode(all.data(), &sense));
    CHECK(sense.buttons == 15);
    CHECK(sense.homed == 7);
}

TEST_CASE("every 16-bit value survives both ways") {
    for (int value = -32768; value <= 32767; ++value) {
        const auto word = static_cast<std::int16_t>(value);
        const Packet packet = encode({word, static_cast<std::int16_t>(~word), 0}, 0, 0);
        pal_sense sense{};
        REQUIRE(pal_wire_decode(packet.data(), &sense));
        REQUIRE(sense.encoder_counts[0] == word);
        REQUIRE(sense.encoder_counts[1] == static_cast<std::int16_t>(~word));
    }
}

TEST_CASE("a reply with any byte out of its range is refused and leaves the sense alone") {
    const Packet good = encode({1, 2, 3}, 0, 0);
    for (std::size_t at = 0; at < PAL_WIRE_BYTES; ++at) {
        for (int byte = 0; byte < 256; ++byte) {
            Packet packet = good;
            packet[at] = static_cast<std::uint8_t>(byte);
            const bool digit = at >= 1 && at <= 12 && byte >= 0x41 && byte <= 0x50;
            const bool flags = at == 13 && byte >= 0x41 && byte <= 0xC0;
            const bool right = digit || flags || at == 14 || packet == good;
            pal_sense sense{};
            REQUIRE(pal_wire_decode(packet.data(), &sense) == right);
            REQUIRE(sense.fresh == (right ? 1 : 0));
        }
    }
}

TEST_CASE("the stream reader finds every whole packet whatever lies between") {
    std::mt19937 random(3);
    pal_wire_reader reader{};
    std::uint32_t n_noise = 0;
    for (int n = 0; n < 5000; ++n) {
        const Packet sent = encode({static_cast<std::int16_t>(n), static_cast<std::int16_t>(-n), 5}, 0, 4);
        const auto n_cut = random() % PAL_WIRE_BYTES;  // the start of a packet that was cut off
        for (std::size_t i = 0; i < n_cut; ++i) REQUIRE_FALSE(pal_wire_feed(&reader, sent[i]));
        n_noise += static_cast<std::uint32_t>(n_cut);
        for (std::size_t i = 0; i + 1 < PAL_WIRE_BYTES; ++i) REQUIRE_FALSE(pal_wire_feed(&reader, sent[i]));
        REQUIRE(pal_wire_feed(&reader, sent[15]));
        REQUIRE(std::memcmp(reader.bytes, sent.data(), sent.size()) == 0);
    }
    CHECK(reader.n_skipped_bytes == n_noise);
}

TEST_CASE("sixteen bytes without an end are dropped and the next packet is found") {
    pal_wire_reader reader{};
    const Packet good = encode({7, 8, 9}, 0, 0);
    for (std::size_t i = 0; i < 15; ++i) REQUIRE_FALSE(pal_wire_feed(&reader, good[i]));
    CHECK_FALSE(pal_wire_feed(&reader, 0x41));
    for (std::size_t i = 0; i < 15; ++i) REQUIRE_FALSE(pal_wire_feed(&reader, good[i]));
    CHECK(pal_wire_feed(&reader, good[15]));
    CHECK(reader.n_skipped_bytes == 16);
}
