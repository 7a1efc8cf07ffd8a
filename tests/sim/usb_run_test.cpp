#include "sim/falcon/usb_device.h"

#include <catch2/catch.hpp>

#include "tests/sim/plain_host.hpp"

using palpate::test::answer_to;
using palpate::test::Bytes;
using palpate::test::bytes_of;
using palpate::test::IDLE;
using palpate::test::Packet;
using palpate::test::part;
using palpate::test::PlainHost;
using palpate::test::read_data;
using palpate::test::running_device;
using palpate::test::ZERO_REQUEST;

TEST_CASE("a device that runs since an earlier session answers at once, without any request to the chip") {
    PlainHost host(running_device());
    host.out(ZERO_REQUEST);
    const auto reply = host.read();
    REQUIRE(reply);
    CHECK(reply->at_us == 1000);
    CHECK(reply->bytes.size() == 18);
}

TEST_CASE("replies carry the encoders, the grip, the homed flags and the unknown nibble") {
    pal_usb_device_config config = running_device();
    config.falcon.start_m[2] = 0.11;  // all encoders -516 = 0xFDFC: docs/PROTOCOL.md 4
    for (int16_t& offset : config.falcon.start_offset_counts) offset = 0;
    config.falcon.reply_spare = 5;
    PlainHost host(config);
    host.begin_run();
    pal_usb_device_press(host.device(), 0x0A);
    CHECK(answer_to(host, ZERO_REQUEST) == bytes_of("<MPNPMPNPMPNPKF>"));
    CHECK(answer_to(host, bytes_of("<AAAAAAAAAAAAJD>")).size() == 16);  // homing, red
    CHECK(host.truth().homing);
    CHECK(host.truth().leds == 8);
    CHECK(host.truth().spare == 3);
}

TEST_CASE("homed flags stay without the homing bit or not, as the option says; the counters stay") {
    const bool needs_bit = GENERATE(as<bool>{}, false, true);
    pal_usb_device_config config = running_device();
    config.falcon.start_m[2] = 0.075;  // inside the homing reference of -15 degrees
    config.falcon.homed_needs_bit = needs_bit;
    PlainHost host(config);
    host.begin_run();
    const Bytes homing = bytes_of("<AAAAAAAAAAAABA>");
    static_cast<void>(answer_to(host, homing));
    host.wait(5000);
    CHECK(host.truth().homed == 7);
    const Bytes with = answer_to(host, homing);
    REQUIRE(with.size() == 16);
    CHECK(with[13] == 0x41 + 0x70);
    const Bytes without = answer_to(host, ZERO_REQUEST);
    REQUIRE(without.size() == 16);
    CHECK(without[13] == (needs_bit ? 0x41 : 0x41 + 0x70));
    CHECK(part(with, 0, 13) == part(without, 0, 13));
    CHECK(answer_to(host, homing) == with);
}

TEST_CASE("each request of the vectors sets the motor words, the lights and homing that it says") {
    struct Row {
        Bytes request;
        int words[3];
        uint8_t leds;
        bool homing;
    };
    const Row rows[] = {
        {ZERO_REQUEST, {0, 0, 0}, 0, false},
        {{0x3C, 0x49, 0x4F, 0x44, 0x41, 0x49, 0x42, 0x4D, 0x50, 0x50, 0x50, 0x50, 0x41, 0x45, 0x41, 0x3E},
         {1000, -1000, 4095},
         4,
         false},
        {{0x3C, 0x42, 0x41, 0x41, 0x50, 0x50, 0x50, 0x50, 0x41, 0x50, 0x50, 0x50, 0x50, 0x49, 0x41, 0x3E},
         {-4095, 4095, -1},
         8,
         false},
        {{0x3C, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41, 0x4A, 0x41, 0x3E},
         {0, 0, 0},
         8,
         true},
        {{0x3C, 0x50, 0x50, 0x50, 0x48, 0x41, 0x41, 0x41, 0x49, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41, 0x3E},
         {4095, -4095, 0},  // 32767, -32768: the motors' words end sooner
         0,
         false},
        {{0x3C, 0x41, 0x4D, 0x4B, 0x41, 0x4D, 0x4E, 0x4B, 0x41, 0x49, 0x45, 0x4C, 0x41, 0x45, 0x41, 0x3E},
         {2752, 2780, 2888},
         4,
         false}};
    PlainHost host(running_device());
    for (const Row& row : rows) {
        CHECK(answer_to(host, row.request).size() == 16);
        host.wait(2000);
        const pal_usb_device_truth truth = host.truth();
        for (std::size_t i = 0; i < 3; ++i) CHECK(truth.motor_counts[i] == row.words[i]);
        CHECK(truth.leds == row.leds);
        CHECK(truth.homing == row.homing);
    }
}

TEST_CASE("motor words act until the watchdog finds the host silent, then they are zero") {
    const uint32_t watchdog_ms = GENERATE(as<uint32_t>{}, 20, 100);
    pal_usb_device_config config = running_device();
    config.falcon.watchdog_ticks = watchdog_ms;
    PlainHost host(config);
    host.begin_run();
    CHECK(answer_to(host, {0x3C, 0x49, 0x4F, 0x44, 0x41, 0x49, 0x42, 0x4D, 0x50, 0x50, 0x50, 0x50, 0x41, 0x45,
                           0x41, 0x3E})
              .size() == 16);
    host.wait(2000);
    CHECK(host.truth().motor_counts[0] == 1000);
    CHECK(host.truth().motor_counts[1] == -1000);
    CHECK(host.truth().motor_counts[2] == 4095);
    CHECK(host.truth().leds == 4);
    CHECK_FALSE(host.truth().watchdog);
    host.wait(1000 * (watchdog_ms - 5));
    CHECK(host.truth().motor_counts[0] == 1000);
    host.wait(5000);
    CHECK(host.truth().watchdog);
    for (const int16_t word : host.truth().motor_counts) CHECK(word == 0);
}

TEST_CASE("a bad, cut or doubled request is handled as a device does that waits for '<'") {
    PlainHost host(running_device());
    host.begin_run();
    const auto n_answers = [&](const Bytes& bytes) {
        host.out(bytes);
        return host.payload(100, 5000).size() / 16;
    };
    CHECK(n_answers(bytes_of("<AAAAAAAAAAAAAAA")) == 0);
    CHECK(n_answers(bytes_of("<AAAAAA<AAAAAAAAAAAAAA>")) == 1);
    CHECK(n_answers(bytes_of("<AAAAAAAAAAAAAA><AAAAAAAAAAAAAA>")) == 2);
    CHECK(n_answers(bytes_of("<AAAAA")) == 0);
    CHECK(n_answers(bytes_of("AAAAAAAAA>")) == 1);
    CHECK(n_answers(bytes_of("<AAAAAAAAQAAAAA>")) == 0);  // 'Q' is no nibble
}

TEST_CASE("the latency timer cuts a reply where it stands, at any byte") {
    const std::size_t n_first = GENERATE(as<std::size_t>{}, 1, 2, 7, 8, 14, 15);
    PlainHost host(running_device());
    host.begin_run();
    REQUIRE(host.read() == Packet{1000, IDLE});
    // 16 bytes of 6.667 us there, n_first back, just when the timer of 1 ms ends; a third of a byte to spare.
    const uint64_t back_us = (320U * (16 + n_first) + 2U * 48U) / 48U;
    host.advance_to(2000 - back_us);
    host.out(ZERO_REQUEST);
    const auto first = host.read();
    const auto second = host.read();
    REQUIRE((first && second));
    CHECK(first->at_us == 2000);
    CHECK(second->at_us == 3000);
    CHECK(first->bytes.size() == 2 + n_first);
    CHECK(second->bytes.size() == 2 + 16 - n_first);
}

TEST_CASE("with '>' as event character a reply comes as soon as it is through") {
    PlainHost host(running_device());
    host.begin_run();
    host.vendor(0x06, 0x013E);
    for (int i = 0; i < 5; ++i) {
        const uint64_t begin_us = host.now_us();
        host.out(ZERO_REQUEST);
        const auto reply = read_data(host);
        REQUIRE(reply);
        CHECK(reply->at_us - begin_us == 214);  // 32 bytes of 6.667 us
        CHECK(reply->bytes.size() == 18);
    }
}
