#include "sim/falcon/loader.h"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/sim/plain_host.hpp"

namespace {

using palpate::test::boot_image;
using palpate::test::Bytes;

constexpr uint32_t AT_9600 = 2500, AT_142857 = 168, AT_115385 = 208, AT_57554 = 417, AT_1500000 = 16;

pal_loader made(pal_loader_config config = {}) {
    if (config.autobaud_sure_baud == 0) config.autobaud_sure_baud = 100000;
    if (config.autobaud_max_baud == 0) config.autobaud_max_baud = 1000000;
    pal_loader loader;
    pal_loader_init(&loader, &config, 1);
    return loader;
}

struct Said {
    Bytes bytes;
    uint32_t clocks_per_bit = 0;
    bool reset = false, started = false, struck = false;
};

Said feed(pal_loader& loader, const Bytes& bytes, uint32_t clocks, const pal_usb_fault* fail = nullptr) {
    Said said;
    for (const uint8_t byte : bytes) {
        const pal_loader_answer answer = pal_loader_receive(&loader, {clocks, byte, true}, fail);
        said.bytes.insert(said.bytes.end(), answer.bytes, answer.bytes + answer.n_bytes);
        if (answer.n_bytes > 0) said.clocks_per_bit = answer.clocks_per_bit;
        said.reset = said.reset || answer.reset;
        said.started = said.started || answer.started;
        said.struck = said.struck || answer.struck;
    }
    return said;
}

const Bytes REQUEST{0x0A, 0x43, 0x0D}, ANSWER{0x0A, 0x44, 0x2C, 0x0D};

pal_loader at_autobaud() {
    pal_loader loader = made();
    pal_loader_set_dtr(&loader, true);
    REQUIRE(feed(loader, REQUEST, AT_9600).bytes == ANSWER);
    pal_loader_set_dtr(&loader, false);
    return loader;
}

pal_loader at_load(uint32_t clocks = AT_142857) {
    pal_loader loader = at_autobaud();
    REQUIRE(feed(loader, {'A'}, clocks).bytes == Bytes{'A'});
    return loader;
}

pal_usb_fault fail_at(int stage, uint32_t byte = 0) {
    pal_usb_fault fault = pal_usb_fault_of(PAL_USB_FAULT_BOOT_FAIL);
    fault.stage = static_cast<uint8_t>(stage);
    fault.byte = byte;
    return fault;
}

}  // namespace

TEST_CASE("the PIC answers LF C CR while DTR is high, at 9600 baud only, and resets the DSP") {
    pal_loader loader = made();
    CHECK(feed(loader, REQUEST, AT_9600).bytes.empty());
    pal_loader_set_dtr(&loader, true);
    CHECK(feed(loader, REQUEST, AT_142857).bytes.empty());
    const Said said = feed(loader, REQUEST, AT_9600);
    CHECK(said.bytes == ANSWER);
    CHECK(said.clocks_per_bit == AT_9600);
    CHECK(said.reset);
    CHECK(feed(loader, REQUEST, AT_9600).bytes == ANSWER);
    CHECK(loader.n_handshakes == 2);
}

TEST_CASE("the PIC finds its request behind rubbish, and needs it whole") {
    pal_loader loader = made();
    pal_loader_set_dtr(&loader, true);
    CHECK(feed(loader, {0x43, 0x0D, 0x0A, 0x0A, 0x43}, AT_9600).bytes.empty());
    CHECK(feed(loader, {0x0D}, AT_9600).bytes == ANSWER);
    CHECK(feed(loader, {0x58, 0x43, 0x0D}, AT_9600).bytes.empty());
    CHECK(feed(loader, {0x0A, 0x43}, AT_9600).bytes.empty());
    pal_loader_set_dtr(&loader, false);
    pal_loader_set_dtr(&loader, true);
    CHECK(feed(loader, {0x0D}, AT_9600).bytes.empty());
}

TEST_CASE("a byte 00 comes before the first answer only, when the option says so") {
    pal_loader_config config{};
    config.zero_before_answer = true;
    pal_loader loader = made(config);
    for (int round = 0; round < 2; ++round) {
        pal_loader_set_dtr(&loader, true);
        CHECK(feed(loader, REQUEST, AT_9600).bytes == Bytes{0x00, 0x0A, 0x44, 0x2C, 0x0D});
        CHECK(feed(loader, REQUEST, AT_9600).bytes == ANSWER);
        pal_loader_set_dtr(&loader, false);
    }
}

TEST_CASE("the ROM locks on 'A' or 'a' at any baud, echoes it, and ignores all else") {
    const uint32_t clocks = GENERATE(as<uint32_t>{}, AT_142857, AT_115385, AT_57554, AT_9600);
    const uint8_t letter = GENERATE(as<uint8_t>{}, 'A', 'a');
    pal_loader loader = at_autobaud();
    CHECK(feed(loader, {0x00, '<', 'B', 0xFF}, clocks).bytes.empty());
    const Said said = feed(loader, {letter}, clocks);
    CHECK(said.bytes == Bytes{letter});
    CHECK(said.clocks_per_bit == clocks);
}

TEST_CASE("a probe at run speed gets no answer from the ROM") {
    pal_loader loader = at_autobaud();
    CHECK(feed(loader, palpate::test::ZERO_REQUEST, AT_1500000).bytes.empty());
    CHECK(loader.dsp == PAL_DSP_AUTOBAUD);
}

TEST_CASE("a byte 13 comes before the echo of 'A' when the option says so") {
    pal_loader_config config{};
    config.xoff_before_echo = true;
    pal_loader loader = made(config);
    CHECK(feed(loader, {'A'}, AT_57554).bytes == Bytes{0x13, 'A'});
}

TEST_CASE("autobaud fails above the sure baud with the probability of the option, never below") {
    pal_loader_config config{};
    config.autobaud_fail_per_million = 250000;
    pal_loader loader = made(config);
    int n_fast = 0;
    int n_slow = 0;
    for (int i = 0; i < 1000; ++i) {
        pal_loader_power(&loader, true);
        n_fast += feed(loader, {'A'}, AT_142857).bytes.empty() ? 1 : 0;
        pal_loader_power(&loader, true);
        n_slow += feed(loader, {'A'}, AT_57554).bytes.empty() ? 1 : 0;
    }
    CHECK(n_slow == 0);
    CHECK(n_fast > 250 - 69);  // five standard deviations
    CHECK(n_fast < 250 + 69);
}

TEST_CASE("every byte of a container is echoed, and the firmware runs once the last one is in") {
    const std::size_t n_words = GENERATE(as<std::size_t>{}, 1, 2, 485, 3643);
    const Bytes image = boot_image(n_words);
    CHECK(image.size() == 30 + 2 * n_words);
    pal_loader loader = at_load();
    const Said but_last = feed(loader, Bytes(image.begin(), image.end() - 1), AT_142857);
    CHECK(but_last.bytes == Bytes(image.begin(), image.end() - 1));
    CHECK_FALSE(but_last.started);
    const Said last = feed(loader, {image.back()}, AT_142857);
    CHECK(last.bytes == Bytes{image.back()});
    CHECK(last.clocks_per_bit == AT_142857);
    CHECK(last.started);
    CHECK(loader.dsp == PAL_DSP_RUN);
    CHECK(loader.n_boots == 1);
}

TEST_CASE("the smallest container of the format boots, and one of several blocks") {
    Bytes image{0xAA, 0x08};
    image.insert(image.end(), 16, 0x00);
    image.insert(image.end(), {0x3F, 0x00, 0x02, 0x80});              // entry point
    image.insert(image.end(), {0x01, 0x00, 0x3F, 0x00, 0x02, 0x80});  // one word, to there
    image.insert(image.end(), {0x00, 0x00});                          // the word: no end, though it is 0
    pal_loader loader = at_load();
    CHECK_FALSE(feed(loader, image, AT_142857).started);
    CHECK(feed(loader, {0, 0}, AT_142857).started);
    image.insert(image.end(), {0x02, 0x00, 0x00, 0x00, 0xA2, 0x93, 1, 2, 3, 4});
    loader = at_load();
    CHECK_FALSE(feed(loader, image, AT_142857).started);
    CHECK(feed(loader, {0, 0}, AT_142857).started);
}

TEST_CASE("a wrong key is echoed, then nothing is, until the PIC resets the DSP") {
    pal_loader loader = at_load();
    CHECK(feed(loader, {0xAA, 0x09}, AT_142857).bytes == Bytes{0xAA, 0x09});
    CHECK(loader.dsp == PAL_DSP_MUTE);
    CHECK(feed(loader, {'A', 'a', 0xAA, 0x08}, AT_142857).bytes.empty());
    pal_loader_set_dtr(&loader, true);
    CHECK(feed(loader, REQUEST, AT_9600).reset);
    pal_loader_set_dtr(&loader, false);
    CHECK(feed(loader, {'A'}, AT_142857).bytes == Bytes{'A'});
}

TEST_CASE("bytes at another baud than that of the lock are read wrong, one by one") {
    pal_loader loader = at_load(AT_142857);
    const Bytes image = boot_image(1);
    const Bytes echo = feed(loader, {image[0]}, AT_115385).bytes;
    REQUIRE(echo.size() == 1);
    CHECK(echo[0] != image[0]);
}

TEST_CASE("a failing boot fails at its stage and no other") {
    const Bytes image = boot_image(4);
    SECTION("the PIC is silent") {
        pal_loader loader = made();
        pal_loader_set_dtr(&loader, true);
        const pal_usb_fault fault = fail_at(PAL_BOOT_FAIL_PIC_SILENT);
        const Said said = feed(loader, REQUEST, AT_9600, &fault);
        CHECK(said.struck);
        CHECK(said.bytes.empty());
        CHECK_FALSE(said.reset);
    }
    SECTION("the PIC's answer is wrong") {
        pal_loader loader = made();
        pal_loader_set_dtr(&loader, true);
        const pal_usb_fault fault = fail_at(PAL_BOOT_FAIL_PIC_WRONG);
        const Said said = feed(loader, REQUEST, AT_9600, &fault);
        CHECK(said.bytes == Bytes{0x0A, 0x44, 0xD3, 0x0D});
        CHECK_FALSE(said.reset);
    }
    SECTION("autobaud does not lock, the next 'A' does") {
        pal_loader loader = at_autobaud();
        const pal_usb_fault fault = fail_at(PAL_BOOT_FAIL_AUTOBAUD_SILENT);
        CHECK(feed(loader, {'A'}, AT_142857, &fault).bytes.empty());
        CHECK(feed(loader, {'A'}, AT_142857).bytes == Bytes{'A'});
    }
    SECTION("autobaud locks wrong") {
        pal_loader loader = at_autobaud();
        const pal_usb_fault fault = fail_at(PAL_BOOT_FAIL_AUTOBAUD_WRONG);
        CHECK(feed(loader, {'A'}, AT_142857, &fault).bytes == Bytes{0xBE});
        CHECK(feed(loader, image, AT_142857).bytes.empty());
    }
    SECTION("one echo is wrong") {
        pal_loader loader = at_load();
        const pal_usb_fault fault = fail_at(PAL_BOOT_FAIL_ECHO_WRONG, 20);
        const Said said = feed(loader, image, AT_142857, &fault);
        Bytes expected = image;
        expected[20] ^= 0xFF;
        CHECK(said.bytes == expected);
        CHECK(said.struck);
    }
    SECTION("the echo ends") {
        pal_loader loader = at_load();
        const pal_usb_fault fault = fail_at(PAL_BOOT_FAIL_ECHO_SILENT, 20);
        const Said said = feed(loader, image, AT_142857, &fault);
        CHECK(said.bytes == Bytes(image.begin(), image.begin() + 20));
        CHECK(loader.dsp == PAL_DSP_MUTE);
    }
    SECTION("nothing starts") {
        pal_loader loader = at_load();
        const pal_usb_fault fault = fail_at(PAL_BOOT_FAIL_NO_START);
        const Said said = feed(loader, image, AT_142857, &fault);
        CHECK(said.bytes == image);
        CHECK_FALSE(said.started);
        CHECK(loader.dsp == PAL_DSP_MUTE);
    }
}

TEST_CASE("without supply nobody answers, and with it the ROM begins anew") {
    pal_loader loader = at_load();
    pal_loader_power(&loader, false);
    CHECK(feed(loader, {0xAA}, AT_142857).bytes.empty());
    pal_loader_set_dtr(&loader, true);
    CHECK(feed(loader, REQUEST, AT_9600).bytes.empty());
    pal_loader_power(&loader, true);
    CHECK(feed(loader, REQUEST, AT_9600).bytes == ANSWER);
}
