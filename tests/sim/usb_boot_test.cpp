#include "sim/falcon/usb_device.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <utility>

#include "tests/sim/plain_host.hpp"

using palpate::test::answer_to;
using palpate::test::boot_image;
using palpate::test::Bytes;
using palpate::test::Packet;
using palpate::test::part;
using palpate::test::PIC_REQUEST;
using palpate::test::PlainHost;
using palpate::test::read_data;
using palpate::test::running_device;
using palpate::test::still_device;
using palpate::test::with_status;
using palpate::test::ZERO_REQUEST;

TEST_CASE(
    "the boot of a 1000-byte image, to the byte and the microsecond, for each option that no source tells") {
    const bool zero = GENERATE(as<bool>{}, false, true);
    const bool xoff = GENERATE(as<bool>{}, false, true);
    const uint32_t pic_us = GENERATE(as<uint32_t>{}, 0, 500);
    const uint32_t start_us = GENERATE(as<uint32_t>{}, 0, 30000);
    const uint64_t begin_us = GENERATE(as<uint64_t>{}, 0, 123456789);
    pal_usb_device_config config = still_device();
    config.loader.zero_before_answer = zero;
    config.loader.xoff_before_echo = xoff;
    config.loader.pic_answer_us = pic_us;
    config.loader.start_us = start_us;
    config.start_us = begin_us;
    PlainHost host(config);
    const Bytes image = boot_image(485);
    REQUIRE(image.size() == 1000);

    host.begin_boot();
    host.out(PIC_REQUEST);
    // 3 + 4 (5) bytes of 1041.67 us are through after 7.3 (8.3) ms; they wait for the timer.
    const Bytes answer = zero ? Bytes{0x00, 0x0A, 0x44, 0x2C, 0x0D} : Bytes{0x0A, 0x44, 0x2C, 0x0D};
    CHECK(host.read() == Packet{begin_us + 16000, with_status(answer)});
    host.set_dtr(false);
    host.set_baud(0x0015);
    host.out({0x41});
    CHECK(host.read() == Packet{begin_us + 32000, with_status(xoff ? Bytes{0x13, 0x41} : Bytes{0x41})});

    uint64_t at_us = begin_us + 32000;
    for (std::size_t at = 0; at < 992; at += 62) {
        host.out(part(image, at, 62));
        at_us += 63 * 70;  // the last echo is through one byte after its byte
        CHECK(host.read() == Packet{at_us, with_status(part(image, at, 62))});
    }
    CHECK(at_us == begin_us + 102560);
    host.out(part(image, 992, 8));
    host.advance_to(at_us + 8 * 70 - 1);
    CHECK(host.truth().dsp == PAL_DSP_LOAD);
    host.advance_to(at_us + 8 * 70);
    CHECK(host.truth().dsp == PAL_DSP_RUN);
    CHECK(host.truth().running == (start_us == 0));
    CHECK(host.read() == Packet{begin_us + 118560, with_status(part(image, 992, 8))});

    host.begin_run();
    host.wait(start_us);
    CHECK(host.truth().running);
    host.set_latency(1);
    host.out(ZERO_REQUEST);
    const auto reply = host.read();
    REQUIRE(reply);
    CHECK(reply->at_us == begin_us + 118560 + start_us + 1000);
    REQUIRE(reply->bytes.size() == 18);
    CHECK(reply->bytes[2] == '<');
    CHECK(reply->bytes[17] == '>');
    CHECK(host.truth().n_boots == 1);
}

TEST_CASE(
    "a host as strict as libnifalcon, which wants each answer in one transfer, boots at the first trial") {
    const bool zero = GENERATE(as<bool>{}, false, true);
    pal_usb_device_config config = still_device();
    config.loader.zero_before_answer = zero;
    PlainHost host(config);
    const auto frame = [&] { host.advance_to((host.now_us() / 1000 + 1) * 1000); };  // a transfer each
    const auto request = [&](uint8_t which, unsigned value) {
        frame();
        REQUIRE(host.vendor(which, value) == 0);
    };
    const auto exchange = [&](const Bytes& bytes, std::size_t n_wanted) {
        frame();
        REQUIRE(host.out(bytes) == static_cast<int>(bytes.size()));
        frame();
        const auto packet = host.read();
        REQUIRE(packet);
        CHECK(packet->bytes.size() == n_wanted);
        return Bytes(packet->bytes.begin() + 2, packet->bytes.end());
    };
    host.wait(5000000);  // it was plugged in long ago
    const std::pair<uint8_t, unsigned> opening[] = {{0, 1}, {0, 2}, {9, 1},      {3, 2},      {0, 1},
                                                    {0, 2}, {0, 1}, {0, 2},      {9, 16},     {3, 0x4138},
                                                    {4, 8}, {2, 0}, {1, 0x0200}, {1, 0x0100}, {1, 0x0101}};
    for (const auto& [which, value] : opening) request(which, value);
    CHECK(exchange(PIC_REQUEST, zero ? 7 : 6).back() == 0x0D);
    request(1, 0x0100);
    request(3, 0x0015);
    CHECK(exchange({0x41}, 3) == Bytes{0x41});
    const Bytes image = boot_image(485);
    for (std::size_t at = 0; at < image.size(); at += 62) {
        const std::size_t n = std::min<std::size_t>(62, image.size() - at);
        CHECK(exchange(part(image, at, n), n + 2) == part(image, at, n));
    }
    const std::pair<uint8_t, unsigned> closing[] = {{9, 1}, {3, 2}, {0, 1}, {0, 2}};
    for (const auto& [which, value] : closing) request(which, value);
    frame();
    host.out(ZERO_REQUEST);
    const auto reply = read_data(host);
    REQUIRE(reply);
    CHECK(reply->bytes.size() == 18);
}

TEST_CASE("with a latency of 1 ms the PIC's answer comes in pieces, each at its tick") {
    PlainHost host(still_device());
    host.begin_boot(1);
    host.out(PIC_REQUEST);
    // The bytes are through at 4166.67, 5208.33, 6250 and 7291.67 us.
    CHECK(host.read() == Packet{1000, {0x01, 0x00}});  // two more bytes wait: neither register is empty
    CHECK(host.read() == Packet{2000, {0x01, 0x00}});
    CHECK(host.read() == Packet{3000, {0x01, 0x20}});
    CHECK(host.read() == Packet{4000, {0x01, 0x60}});
    CHECK(host.read() == Packet{5000, {0x01, 0x60, 0x0A}});
    CHECK(host.read() == Packet{6000, {0x01, 0x60, 0x44}});
    CHECK(host.read() == Packet{7000, {0x01, 0x60, 0x2C}});
    CHECK(host.read() == Packet{8000, {0x01, 0x60, 0x0D}});
    CHECK(host.read() == Packet{9000, {0x01, 0x60}});
}

TEST_CASE("the PIC takes its time before it answers, when the option says so") {
    pal_usb_device_config config = still_device();
    config.loader.pic_answer_us = 700;
    PlainHost host(config);
    host.begin_boot();
    host.vendor(0x06, 0x0144);  // event character 'D', the second byte
    host.out(PIC_REQUEST);
    CHECK(host.read() == Packet{3125 + 700 + 2084, with_status({0x0A, 0x44})});
}

TEST_CASE("an echo that comes after the host changed its baud is read wrong, with a framing error") {
    PlainHost host(still_device());
    host.begin_boot();
    host.out(PIC_REQUEST);
    REQUIRE(host.payload(4).size() == 4);
    host.set_dtr(false);
    host.set_baud(0x0015);
    const uint64_t begin_us = host.now_us();
    host.out({0x41});
    host.wait(139);
    host.set_baud(0x0002);
    const auto echo = host.read();
    REQUIRE(echo);
    CHECK(echo->at_us == begin_us + 140);
    REQUIRE(echo->bytes.size() == 3);
    CHECK(echo->bytes[1] == 0x68);
    CHECK(echo->bytes[2] != 0x41);
    CHECK(host.truth().dsp == PAL_DSP_LOAD);
}

TEST_CASE("the counters begin somewhere else at each start of the firmware") {
    PlainHost host(still_device());
    REQUIRE(host.boot(boot_image(3)));
    const Bytes first = answer_to(host, ZERO_REQUEST);
    CHECK(answer_to(host, ZERO_REQUEST) == first);
    REQUIRE(host.boot(boot_image(3)));
    CHECK(answer_to(host, ZERO_REQUEST) != first);
}

TEST_CASE("an upload at another baud than that of 'A' never boots") {
    const unsigned baud = GENERATE(as<unsigned>{}, 0x001A, 0xC034, 0x4138, 0x0002);
    PlainHost host(still_device());
    host.begin_boot();
    host.out(PIC_REQUEST);
    REQUIRE(host.payload(4).size() == 4);
    host.set_dtr(false);
    host.set_baud(0x0015);
    host.out({0x41});
    REQUIRE(host.payload(1) == Bytes{0x41});
    host.set_baud(baud);
    const Bytes image = boot_image(20);
    host.out(part(image, 0, 62));
    const Bytes echo = host.payload(62, 200000);
    CHECK(echo != part(image, 0, 62));
    host.out(part(image, 62, image.size() - 62));
    host.wait(200000);
    CHECK_FALSE(host.truth().running);
    CHECK(host.truth().n_boots == 0);
}

TEST_CASE("a boot at any of the bauds works, and a later one as well") {
    const unsigned baud = GENERATE(as<unsigned>{}, 0x0015, 0x001A, 0xC034, 0xC04E);
    PlainHost host(still_device());
    CHECK(host.boot(boot_image(100), baud));
    CHECK(answer_to(host, ZERO_REQUEST).size() == 16);
    CHECK(host.boot(boot_image(7), baud));
    CHECK(answer_to(host, ZERO_REQUEST).size() == 16);
    CHECK(host.truth().n_boots == 2);
}

TEST_CASE("before its boot the device is silent, and the probes disturb no boot") {
    PlainHost host(still_device());
    host.begin_run();
    for (int i = 0; i < 20; ++i) {
        host.out(ZERO_REQUEST);
        CHECK(host.payload(1, 5000).empty());
    }
    CHECK(host.boot(boot_image(3)));
}

TEST_CASE(
    "a running firmware goes on through DTR, until the PIC's handshake puts the DSP back into its ROM") {
    PlainHost host(running_device());
    host.begin_run();
    CHECK(answer_to(host, ZERO_REQUEST).size() == 16);
    host.set_dtr(true);
    host.out(ZERO_REQUEST);
    CHECK(host.payload(1, 5000).empty());  // the PIC has the line
    host.set_dtr(false);
    CHECK(answer_to(host, ZERO_REQUEST).size() == 16);
    host.begin_boot();
    host.out(PIC_REQUEST);
    CHECK(host.payload(4) == Bytes{0x0A, 0x44, 0x2C, 0x0D});
    CHECK_FALSE(host.truth().running);
    host.set_dtr(false);
    host.begin_run();
    host.out(ZERO_REQUEST);
    CHECK(host.payload(1, 5000).empty());
}

TEST_CASE("an echo of 64 bytes comes as 62 at once and two with the timer") {
    PlainHost host(still_device());
    host.begin_boot();
    host.out(PIC_REQUEST);
    static_cast<void>(host.payload(4));
    host.set_dtr(false);
    host.set_baud(0x0015);
    host.out({0x41});
    REQUIRE(host.payload(1) == Bytes{0x41});
    const uint64_t begin_us = host.now_us();
    const Bytes image = boot_image(100);
    CHECK(host.out(part(image, 0, 64)) == 64);
    const auto full = host.read();
    REQUIRE(full);
    CHECK(full->at_us == begin_us + 63 * 70);
    CHECK(full->bytes.size() == 64);
    CHECK(part(full->bytes, 2, 62) == part(image, 0, 62));
    CHECK(host.read() == Packet{begin_us + 63 * 70 + 16000, with_status(part(image, 62, 2))});
}
