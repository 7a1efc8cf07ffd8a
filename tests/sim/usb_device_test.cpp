#include "sim/falcon/usb_device.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/sim/plain_host.hpp"

using palpate::test::boot_image;
using palpate::test::Bytes;
using palpate::test::bytes_of;
using palpate::test::IDLE;
using palpate::test::Packet;
using palpate::test::part;
using palpate::test::PIC_REQUEST;
using palpate::test::PlainHost;
using palpate::test::running_device;
using palpate::test::still_device;
using palpate::test::with_status;
using palpate::test::ZERO_REQUEST;

TEST_CASE("the descriptors are those of an FT232R in the Falcon's name") {
    PlainHost host(still_device());
    REQUIRE(host.ok());
    CHECK(host.ask(0x80, 6, 0x0100, 0, 64) ==
          Bytes{18, 1, 0x00, 0x02, 0, 0, 0, 8, 0x03, 0x04, 0x48, 0xCB, 0x00, 0x06, 1, 2, 3, 1});
    const Bytes configuration{9,   2, 32, 0, 1,    1, 0,  0xA0, 45, 9, 4, 0,    0, 2,  255, 255,
                              255, 2, 7,  5, 0x81, 2, 64, 0,    0,  7, 5, 0x02, 2, 64, 0,   0};
    CHECK(host.ask(0x80, 6, 0x0200, 0, 255) == configuration);
    CHECK(host.ask(0x80, 6, 0x0200, 0, 9) == part(configuration, 0, 9));
    CHECK(host.ask(0x80, 6, 0x0300, 0, 255) == Bytes{4, 3, 0x09, 0x04});
    CHECK(host.ask(0x80, 6, 0x0302, 0x0409, 255) == Bytes{28,  3, 'F', 0, 'A', 0, 'L', 0, 'C', 0,
                                                          'O', 0, 'N', 0, ' ', 0, 'H', 0, 'A', 0,
                                                          'P', 0, 'T', 0, 'I', 0, 'C', 0});
    CHECK(host.ask(0x80, 6, 0x0303, 0x0409, 255).size() == 18);
    CHECK(host.control(0x80, 6, 0x0304, 0x0409) == PAL_USB_STALL);
    CHECK(host.control(0x80, 6, 0x0600, 0) == PAL_USB_STALL);  // no qualifier: full speed only
}

TEST_CASE("the EEPROM holds the identity and FTDI's check sum") {
    PlainHost host(still_device());
    uint16_t sum = 0xAAAA;
    std::vector<uint16_t> words;
    for (unsigned i = 0; i < 64; ++i) {
        const Bytes word = host.ask(0xC0, 0x90, 0, i, 2);
        REQUIRE(word.size() == 2);
        words.push_back(static_cast<uint16_t>(word[0] | word[1] << 8));
    }
    for (unsigned i = 0; i < 63; ++i) {
        const unsigned mixed = sum ^ words[i];
        sum = static_cast<uint16_t>(mixed << 1U | mixed >> 15U);
    }
    CHECK(words[63] == sum);
    CHECK(words[1] == 0x0403);
    CHECK(words[2] == 0xCB48);
    CHECK(words[3] == 0x0600);
}

TEST_CASE("standard requests are answered as the device's state is") {
    PlainHost host(still_device());
    CHECK(host.ask(0x80, 8, 0, 0, 1) == Bytes{1});
    CHECK(host.ask(0x80, 0, 0, 0, 2) == Bytes{0, 0});
    CHECK(host.control(0x00, 3, 1, 0) == 0);  // may wake the host
    CHECK(host.ask(0x80, 0, 0, 0, 2) == Bytes{2, 0});
    CHECK(host.ask(0x81, 10, 0, 0, 1) == Bytes{0});
    CHECK(host.control(0x01, 11, 0, 0) == 0);
    CHECK(host.control(0x01, 11, 1, 0) == PAL_USB_STALL);
    CHECK(host.control(0x00, 5, 7, 0) == 0);
    CHECK(host.control(0x00, 9, 2, 0) == PAL_USB_STALL);
    CHECK(host.control(0x02, 3, 0, 0x81) == 0);
    CHECK(host.ask(0x82, 0, 0, 0x81, 2) == Bytes{1, 0});
    Bytes packet;
    CHECK(host.in(packet) == PAL_USB_STALL);
    CHECK(host.out({1}) == 1);
    CHECK(host.control(0x02, 1, 0, 0x81) == 0);
    CHECK(host.in(packet) == 0);
    CHECK(host.control(0x00, 9, 0, 0) == 0);  // not configured: no endpoints
    CHECK(host.in(packet) == PAL_USB_STALL);
    CHECK(host.out({1}) == PAL_USB_STALL);
    CHECK(host.control(0x02, 12, 0, 0x81) == PAL_USB_STALL);
    CHECK(host.control(0x21, 0, 0, 0) == PAL_USB_STALL);
}

TEST_CASE("the chip refuses a packet for which it has no room, and takes it when bytes have left") {
    PlainHost host(still_device());
    const Bytes packet(64, 0x55);
    CHECK(host.out(packet) == 64);
    CHECK(host.out(packet) == 64);
    CHECK(host.out(packet) == 0);
    host.wait(63 * 1042);  // at 9600 baud; one byte was on the line at once
    CHECK(host.out(packet) == 64);
    CHECK(host.out(Bytes(65, 0)) == PAL_USB_STALL);
}

TEST_CASE("what happens depends on the transfers, not on how often the device is advanced") {
    const auto run = [](uint64_t step_us) {
        pal_usb_device_config config = pal_usb_device_config_default();
        config.loader.autobaud_fail_per_million = 0;
        PlainHost host(config);
        Bytes all;
        const auto wait = [&](uint64_t us) {
            for (const uint64_t end = host.now_us() + us; host.now_us() < end;) {
                host.wait(std::min(step_us, end - host.now_us()));
            }
            Bytes packet;
            while (host.in(packet) > 0) all.insert(all.end(), packet.begin(), packet.end());
        };
        host.begin_boot();
        host.out(PIC_REQUEST);
        wait(20000);
        host.set_dtr(false);
        host.set_baud(0x0015);
        host.out({0x41});
        wait(20000);
        host.out(boot_image(17));
        wait(20000);
        host.begin_run();
        for (int i = 0; i < 5; ++i) {
            host.out(bytes_of("<AAABAAACAAADBA>"));
            wait(1357);
        }
        return all;
    };
    const Bytes coarse = run(1000000);
    CHECK(coarse.size() > 150);
    CHECK(coarse == run(1));
    CHECK(coarse == run(333));
}

TEST_CASE("next_us is never too late: asking each microsecond finds nothing sooner") {
    const bool event = GENERATE(as<bool>{}, false, true);
    const auto run = [&](bool each) {
        PlainHost host(still_device());
        std::vector<Packet> packets;
        packets.reserve(32);
        const auto read = [&] {
            if (!each) return host.read();
            for (;;) {
                Bytes packet;
                if (host.in(packet) > 0) return std::optional<Packet>(Packet{host.now_us(), packet});
                host.wait(1);
            }
        };
        host.begin_boot();
        host.set_dtr(false);
        host.set_baud(0x0015);
        host.out({'A', 'A', 'A', 'A'});
        host.set_baud(0x4138);  // the ROM locks on the first byte; its echo is too fast for the bridge now
        for (int i = 0; i < 2; ++i) packets.push_back(*read());
        host.begin_boot();
        if (event) host.vendor(0x06, 0x0144);  // the 'D' of the PIC, too
        host.out({0x0A, 0x43, 0x0D, 0x0A, 0x43, 0x0D});
        for (int i = 0; i < 3; ++i) packets.push_back(*read());
        host.set_dtr(false);
        host.set_baud(0x0015);
        host.out({0x41});
        packets.push_back(*read());
        host.out(part(boot_image(50), 0, 64));
        host.out(part(boot_image(50), 64, 64));
        for (int i = 0; i < 5; ++i) packets.push_back(*read());
        host.out(part(boot_image(50), 128, 2));
        packets.push_back(*read());
        CHECK(host.truth().n_boots == 1);
        host.begin_run();
        if (event) host.vendor(0x06, 0x013E);
        for (int i = 0; i < 8; ++i) {
            host.out(ZERO_REQUEST);
            if (i % 2 == 0)
                host.out(bytes_of("<AAAAAAAAAAAAAA><AAAAAAAAAAAAAA><AAAAAAAAAAAAAA><AAAAAAAAAAA"));
            packets.push_back(*read());
        }
        host.set_baud(0x0015);  // now all is garbled
        host.out(ZERO_REQUEST);
        for (int i = 0; i < 8; ++i) packets.push_back(*read());
        return packets;
    };
    CHECK(run(false) == run(true));
}

TEST_CASE("an instant device answers in no time: the boot, the packets; only idle packets wait") {
    pal_usb_device_config config = still_device();
    config.instant = true;
    PlainHost host(config);
    host.begin_boot();
    host.out(PIC_REQUEST);
    CHECK(host.read() == Packet{0, with_status({0x0A, 0x44, 0x2C, 0x0D})});
    host.set_dtr(false);
    host.set_baud(0x0015);
    host.out({0x41});
    CHECK(host.read() == Packet{0, with_status({0x41})});
    const Bytes image = boot_image(485);
    for (std::size_t at = 0; at < 992; at += 62) {
        host.out(part(image, at, 62));
        CHECK(host.read() == Packet{0, with_status(part(image, at, 62))});
    }
    host.out(part(image, 992, 8));
    CHECK(host.read() == Packet{0, with_status(part(image, 992, 8))});
    host.begin_run();
    host.out(ZERO_REQUEST);
    const auto reply = host.read();
    REQUIRE(reply);
    CHECK(reply->at_us == 0);
    CHECK(reply->bytes.size() == 18);
    CHECK(host.read() == Packet{1000, IDLE});
}

TEST_CASE("the hand is asked before each millisecond and pushes the grip") {
    struct Hand {
        int n_ticks = 0;
        double last_z_m = 0;
    } hand;
    pal_usb_device_config config = still_device();
    config.hand.context = &hand;
    config.hand.mass_kg = 0.1;
    config.hand.advance = [](void* context, bool homed, const double position_m[3]) {
        auto& self = *static_cast<Hand*>(context);
        CHECK_FALSE(homed);
        ++self.n_ticks;
        self.last_z_m = position_m[2];
    };
    config.hand.push = [](const void*, const double*, const double*, double force_n[3]) {
        force_n[0] = force_n[1] = 0;
        force_n[2] = 3;
    };
    PlainHost host(config);
    host.advance_to(49999);
    CHECK(hand.n_ticks == 49);
    host.advance_to(50000);
    CHECK(hand.n_ticks == 50);
    CHECK(hand.last_z_m > 0.12);
    CHECK(host.truth().position_m[2] > hand.last_z_m);
}

TEST_CASE("another seed is another device, within 30 %, and the same seed the same one") {
    const pal_falcon_sim_config usual = pal_falcon_sim_config_default();
    const auto drawn = [&](uint64_t seed) {
        pal_falcon_sim_config config = usual;
        pal_falcon_sim_vary(&config, seed, 0.3);
        return config;
    };
    double least = 2;
    double most = 0;
    for (uint64_t seed = 0; seed < 200; ++seed) {
        const pal_falcon_sim_config one = drawn(seed);
        for (const double factor :
             {one.mass_kg / usual.mass_kg, one.viscous_n_s_per_m / usual.viscous_n_s_per_m,
              one.coulomb_n / usual.coulomb_n, one.units_per_n_m / usual.units_per_n_m}) {
            CHECK(factor >= 0.7 - 1e-12);
            CHECK(factor <= 1.3 + 1e-12);
            least = std::min(least, factor);
            most = std::max(most, factor);
        }
        CHECK(one.mass_kg == drawn(seed).mass_kg);
        CHECK(one.mass_kg != drawn(seed + 1).mass_kg);
        CHECK(one.start_offset_counts[0] != drawn(seed + 1).start_offset_counts[0]);
        pal_falcon_sim sim;
        CHECK(pal_falcon_sim_init(&sim, &one));
    }
    CHECK(least < 0.72);
    CHECK(most > 1.28);
}

TEST_CASE("a configuration that makes no sense is refused") {
    pal_usb_device_config config = still_device();
    SECTION("texts too long for the EEPROM") {
        for (char* text : {config.manufacturer, config.product, config.serial}) {
            std::fill_n(text, PAL_USB_TEXT_BYTES - 1, 'x');
        }
    }
    SECTION("a text without an end") {
        std::fill_n(config.serial, PAL_USB_TEXT_BYTES, 'x');
    }
    SECTION("mechanics") {
        config.falcon.mass_kg = -1;
    }
    SECTION("a hand") {
        config.hand.mass_kg = -1;
    }
    SECTION("an unknown nibble of five bits") {
        config.falcon.reply_spare = 16;
    }
    CHECK_FALSE(PlainHost(config).ok());
}
