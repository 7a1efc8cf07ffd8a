#include "host/rig/frame.hpp"

#include <catch2/catch.hpp>

#include "host/rig/map.hpp"
#include "tests/host/rig/client.hpp"

using namespace palpate::rig;
using namespace palpate::rig::test;

namespace {
constexpr Sizes SIZES{.n_words = 26, .n_coils = 2};
}

TEST_CASE("a frame is as long as its header says, and not there before its last byte") {
    const Bytes frame = hex("00 01 00 00 00 06 01 04 00 00 00 10");
    const std::span<const std::uint8_t> bytes(frame);
    for (std::size_t n = 0; n < frame.size(); ++n) CHECK(frame_bytes(bytes.first(n)) == 0U);
    CHECK(frame_bytes(bytes) == 12U);
    CHECK(frame_bytes(frame + hex("00 02 00")) == 12U);
}

TEST_CASE("bytes that are not Modbus TCP are told as soon as they are seen") {
    CHECK_FALSE(frame_bytes(hex("47 45 54 20")));        // "GET "
    CHECK_FALSE(frame_bytes(hex("00 01 00 00 00 01")));  // no room for a function
    CHECK_FALSE(frame_bytes(hex("00 01 00 00 00 FF")));  // longer than any frame
    CHECK_FALSE(frame_bytes(hex("00 01 00 00 FF FF")));
    CHECK_FALSE(frame_bytes(hex("00 01 00 00 00 06 01 00")));  // functions are 1 to 127
    CHECK_FALSE(frame_bytes(hex("00 01 00 00 00 06 01 84")));
    CHECK(frame_bytes(hex("00 01 00 00 00 FE")) == 0U);
}

TEST_CASE("a request is answerable exactly when it stays inside the map") {
    for (unsigned address = 0; address < 40; ++address) {
        for (unsigned quantity = 0; quantity < 40; ++quantity) {
            const Bytes request =
                hex("00 01 00 00 00 06 01 04 00") +
                Bytes{static_cast<std::uint8_t>(address), 0, static_cast<std::uint8_t>(quantity)};
            const bool inside = quantity >= 1 && address + quantity <= SIZES.n_words;
            CHECK((verdict_on(request, SIZES) == Verdict::Answer) == inside);
        }
    }
}

TEST_CASE("what a write changes is read from its bits") {
    const CoilWrite on = coil_write(hex("00 01 00 00 00 06 01 05 00 01 FF 00"));
    CHECK((on.mask == 2 && on.values == 2));
    const CoilWrite off = coil_write(hex("00 01 00 00 00 06 01 05 00 00 00 00"));
    CHECK((off.mask == 1 && off.values == 0));
    const CoilWrite both = coil_write(hex("00 01 00 00 00 08 01 0F 00 00 00 02 01 FE"));
    CHECK((both.mask == 3 && both.values == 2));
    const CoilWrite read = coil_write(hex("00 01 00 00 00 06 01 01 00 00 00 02"));
    CHECK((read.mask == 0 && read.values == 0));
}

TEST_CASE("values are split into words with the high word first") {
    Shown shown;
    shown.state = 3;
    shown.tick = 0x12345678;
    shown.rate_hz = 1000.0F;  // 0x447A0000
    shown.force_n = 3.25F;    // 0x40500000
    shown.z_m = -0.125F;      // 0xBE000000
    const auto now = words(shown);
    CHECK(now[0] == 3);
    CHECK(now[1] == MAP_VERSION);
    CHECK((now[2] == 0x1234 && now[3] == 0x5678));
    CHECK((now[4] == 0x447A && now[5] == 0x0000));
    CHECK((now[6] == 0x4050 && now[7] == 0x0000));
    CHECK((now[24] == 0xBE00 && now[25] == 0x0000));
}
