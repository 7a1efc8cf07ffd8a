#include "tests/firmware/falcon_script.hpp"

#include <array>

namespace {

using namespace script;
using Lines = std::vector<std::string>;

// docs/PROTOCOL.md 4: the bridge, whatever the last session left.
const Lines CHIP{"C 00 0000 0000", "C 04 0008 0000", "C 02 0000 0000", "C 06 0000 0000", "C 07 0000 0000",
                 "C 01 0200 0000", "C 01 0100 0000", "C 00 0001 0000", "C 00 0002 0000"};
const Lines RUN{"C 09 0002 0000", "C 03 0002 0000", "C 06 013E 0000", "C 00 0001 0000", "C 00 0002 0000"};

Lines operator+(Lines a, const Lines& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

// Quick to fail, for sweeps.
pal_falcon_config once(const Bytes& image) {
    pal_falcon_config config = Session::config_for(image);
    config.boot.n_attempts = 1;
    config.boot.n_asks = 3;
    config.boot.n_first = 3;
    return config;
}

}  // namespace

TEST_CASE("a boot is this sequence of requests and bytes and no other") {
    Session s;
    REQUIRE(s.start(Session::config_for(s.device.image)) == PAL_FALCON_OK);
    REQUIRE(s.run_to(PAL_FALCON_HOMING));
    const Lines restart{"C 09 0010 0000", "C 03 4138 0000", "C 01 0101 0000", "W 0A430D"};
    const Lines load{"C 01 0100 0000", "C 03 0015 0000", "W 41",
                     "W AA08000000000000000000000000000000003F00028001003F00028000000000"};
    CHECK(s.device.log == CHIP + restart + load + RUN + Lines{ZERO_FORCE});
}

TEST_CASE("the event character is set only where it is wanted, at run time") {
    Session s;
    pal_falcon_config config = Session::config_for(s.device.image);
    config.boot.event_char = false;
    config.boot.run_latency_ms = 1;
    REQUIRE(s.start(config) == PAL_FALCON_OK);
    REQUIRE(s.run_to(PAL_FALCON_HOMING));
    CHECK(lines(s.device.log, "C 06") == Lines{"C 06 0000 0000"});
    CHECK(lines(s.device.log, "C 09 0001") == Lines{"C 09 0001 0000"});
}

TEST_CASE("a long image goes out in chunks of 62 bytes, each after the echo of the one before") {
    Session s;
    s.device.image = container(100);  // 230 bytes
    REQUIRE(s.start(Session::config_for(s.device.image)) == PAL_FALCON_OK);
    std::vector<std::size_t> sizes;
    Bytes sent;
    std::uint32_t n_echoed_max = 0;
    s.device.tamper = [&](std::size_t, const Bytes& bytes, Bytes&) {
        if (s.falcon.boot.stage != PAL_STAGE_UPLOAD || bytes.size() < 3) return;
        CHECK(s.status().n_echoed_bytes == sent.size());
        sizes.push_back(bytes.size());
        sent.insert(sent.end(), bytes.begin(), bytes.end());
        n_echoed_max = std::max(n_echoed_max, s.status().n_echoed_bytes);
    };
    REQUIRE(s.run_to(PAL_FALCON_HOMING));
    CHECK(sizes == std::vector<std::size_t>{62, 62, 62, 44});
    CHECK(sent == s.device.image);
    CHECK(n_echoed_max == 186);
    CHECK(s.status().n_image_bytes == 230);
}

TEST_CASE("noise before the answers and any cut of them into packets do not matter") {
    const std::size_t cut = GENERATE(range(std::size_t{1}, std::size_t{63}));
    for (const Bytes& before_answer :
         {Bytes{}, Bytes{0x00}, Bytes{0x0A}, Bytes{0x0A, 0x44, 0x0A}, Bytes{0xFF, 0x00}}) {
        for (const Bytes& before_a : {Bytes{}, Bytes{0x13}, Bytes{0x00, 0xFF, 0x0D}}) {
            Session s;
            s.device.image = container(100);
            s.device.before_answer = before_answer;
            s.device.before_a = before_a;
            s.device.cuts = {cut};
            s.device.status_between = cut % 2 == 1;
            REQUIRE(s.start(once(s.device.image)) == PAL_FALCON_OK);
            REQUIRE(s.run_to(PAL_FALCON_HOMING));
        }
    }
}

TEST_CASE("an answer with one byte wrong is none") {
    const std::size_t at = GENERATE(range(std::size_t{0}, std::size_t{4}));
    Session s;
    s.device.tamper = [&](std::size_t, const Bytes& sent, Bytes& said) {
        if (sent.size() == 3) said[at] = 0x20;
    };
    REQUIRE(s.start(once(s.device.image)) == PAL_FALCON_OK);
    REQUIRE(s.boot());
    CHECK(s.status().failure == PAL_FAIL_NO_PIC);
    CHECK(s.device.n_writes == 3);
}

TEST_CASE("two answers to questions that came late do not disturb the loader") {
    Session s;
    s.device.answer_us = 99000;
    s.device.tamper = [&](std::size_t k, const Bytes&, Bytes& said) {
        if (k < 2) said.clear();
        if (k == 2) said = {0x0A, 0x44, 0x2C, 0x0D, 0x0A, 0x44, 0x2C, 0x0D};
        if (k == 3) said.insert(said.begin(), {0x0A, 0x44, 0x2C, 0x0D});
        if (k > 3) s.device.answer_us = 500;
    };
    REQUIRE(s.start(Session::config_for(s.device.image)) == PAL_FALCON_OK);
    REQUIRE(s.run_to(PAL_FALCON_HOMING));
    CHECK(s.status().attempt == 1);
}

TEST_CASE("each attempt starts from the boot controller, at the next rate of the list") {
    Session s;
    s.device.tamper = [&](std::size_t, const Bytes& sent, Bytes& said) {
        if (sent == Bytes{0x41}) said.clear();
    };
    REQUIRE(s.start(Session::config_for(s.device.image)) == PAL_FALCON_OK);
    REQUIRE(s.run_to(PAL_FALCON_FAULT));
    CHECK(s.status().failure == PAL_FAIL_NO_AUTOBAUD);
    CHECK(s.status().at_stage == PAL_STAGE_AUTOBAUD);
    const Lines pic{"C 03 4138 0000"};
    const Lines fast{"C 03 0015 0000"};
    const Lines slow{"C 03 001A 0000"};
    const Lines slowest{"C 03 C034 0000"};
    CHECK(lines(s.device.log, "C 03") ==
          pic + fast + pic + fast + pic + slow + pic + slowest + pic + fast + pic + fast);
    CHECK(lines(s.device.log, "C 01 0101") == Lines(6, "C 01 0101 0000"));
    CHECK(lines(s.device.log, "C 00 0000") == Lines(6, "C 00 0000 0000"));
}

TEST_CASE("a boot that fails k times succeeds at the next attempt") {
    const std::uint32_t n_bad = GENERATE(range(0U, 6U));
    const int how = GENERATE(range(0, 4));
    Session s;
    s.device.image = container(40);
    s.device.tamper = [&](std::size_t, const Bytes& sent, Bytes& said) {
        if (s.status().attempt > n_bad) return;
        if (how == 0 && sent == Bytes{0x0A, 0x43, 0x0D}) said.clear();
        if (how == 1 && sent == Bytes{0x41}) said = {0x61};
        if (how == 2 && sent.size() == 62) said[30] = static_cast<std::uint8_t>(said[30] ^ 0x10U);
        if (how == 3 && sent.size() == 16) said.clear();
    };
    REQUIRE(s.start(Session::config_for(s.device.image)) == PAL_FALCON_OK);
    REQUIRE(s.run_to(PAL_FALCON_HOMING));
    CHECK(s.status().attempt == n_bad + 1);
}

TEST_CASE("a device without power is named, within the sum of the waits") {
    Session s;
    s.device.powered = false;
    const pal_falcon_config config = Session::config_for(s.device.image);
    REQUIRE(s.start(config) == PAL_FALCON_OK);
    const std::uint64_t began_us = s.now_us;
    REQUIRE(s.boot());
    CHECK(s.falcon.state == PAL_FALCON_FAULT);
    CHECK(s.status().failure == PAL_FAIL_NO_PIC);
    CHECK(lines(s.device.log, "W 0A430D").size() == 6 * 25);
    const std::uint64_t n_transfers = s.device.log.size();
    const std::uint64_t waits_us = 6 * (10000 + 25 * 100000) + n_transfers * s.transfer_us;
    CHECK(s.now_us - began_us == waits_us + 1);  // the step that finds out
    CHECK(std::string(pal_falcon_words(&s.falcon)).find("Plug in its power supply") != std::string::npos);
}

TEST_CASE("a wrong or missing echo names its byte, for every byte of the image") {
    const Bytes image = container(49);  // 128 bytes
    const bool wrong = GENERATE(true, false);
    for (std::size_t n = 0; n < image.size(); ++n) {
        Session s;
        s.device.image = image;
        std::size_t n_before = 0;
        s.device.tamper = [&](std::size_t, const Bytes& sent, Bytes& said) {
            if (s.falcon.boot.stage != PAL_STAGE_UPLOAD) return;
            if (n >= n_before && n < n_before + sent.size()) {
                if (wrong)
                    said[n - n_before] = static_cast<std::uint8_t>(~said[n - n_before]);
                else
                    said.resize(n - n_before);
            }
            n_before += sent.size();
        };
        REQUIRE(s.start(once(image)) == PAL_FALCON_OK);
        REQUIRE(s.boot());
        REQUIRE(s.status().failure == (wrong ? PAL_FAIL_ECHO_WRONG : PAL_FAIL_ECHO_TIMEOUT));
        REQUIRE(s.status().at_stage == PAL_STAGE_UPLOAD);
        REQUIRE(s.status().failed_byte == n);
    }
}

TEST_CASE("firmware that does not answer after the upload is named") {
    Session s;
    s.device.tamper = [&](std::size_t, const Bytes& sent, Bytes& said) {
        if (sent.size() == 16) said.clear();
    };
    REQUIRE(s.start(once(s.device.image)) == PAL_FALCON_OK);
    REQUIRE(s.boot());
    CHECK(s.status().failure == PAL_FAIL_NO_REPLY);
    CHECK(s.status().at_stage == PAL_STAGE_FIRST_REPLY);
    CHECK(lines(s.device.log, ZERO_FORCE).size() == 3);
}

TEST_CASE("without reloading, one packet of zero force finds the firmware that runs") {
    Session s;
    s.device.dsp = Dsp::run;
    pal_falcon_config config = pal_falcon_config_default();
    config.boot.reload = PAL_RELOAD_NEVER;
    REQUIRE(s.start(config) == PAL_FALCON_OK);
    REQUIRE(s.run_to(PAL_FALCON_HOMING));
    CHECK(s.device.log == CHIP + RUN + Lines{ZERO_FORCE});
}

TEST_CASE("a probe that nobody answers is one packet, then a fault or a boot as was asked") {
    Session s;
    pal_falcon_config config = Session::config_for(s.device.image);
    SECTION("never") {
        config.boot.reload = PAL_RELOAD_NEVER;
        REQUIRE(s.start(config) == PAL_FALCON_OK);
        REQUIRE(s.boot());
        CHECK(s.status().failure == PAL_FAIL_NO_FIRMWARE);
        CHECK(s.device.log == CHIP + RUN + Lines{ZERO_FORCE});
    }
    SECTION("if silent") {
        config.boot.reload = PAL_RELOAD_IF_SILENT;
        REQUIRE(s.start(config) == PAL_FALCON_OK);
        REQUIRE(s.run_to(PAL_FALCON_HOMING));
        CHECK(lines(s.device.log, ZERO_FORCE).size() == 2);
        CHECK(lines(s.device.log, "W 0A430D").size() == 1);
    }
}

TEST_CASE("whatever falls silent at whatever write, the boot ends in a named fault and in bounded time") {
    const Bytes image = container(100);
    for (std::size_t silent_from = 0; silent_from < 10; ++silent_from) {
        Session s;
        s.device.image = image;
        s.device.tamper = [&](std::size_t k, const Bytes&, Bytes& said) {
            if (k >= silent_from) said.clear();
        };
        const pal_falcon_config config = once(image);
        REQUIRE(s.start(config) == PAL_FALCON_OK);
        const std::uint64_t began_us = s.now_us;
        REQUIRE(s.run_to(PAL_FALCON_FAULT, 3000000));
        CHECK(s.status().failure != PAL_FAIL_NONE);
        CHECK(s.now_us - began_us < 10000 + 3 * 100000 + 100000 + 200000 + 20 * 55000 + 100000);
        CHECK(std::string(pal_falcon_words(&s.falcon)).size() > 20);
        // Nothing but zero force was ever sent in a run-time packet, and nothing more comes.
        const std::size_t n_log = s.device.log.size();
        for (int n = 0; n < 100; ++n) s.step();
        CHECK((s.falcon.state == PAL_FALCON_FAULT || silent_from >= 7));
        if (s.status().at_stage < PAL_STAGE_HOMING) CHECK(s.device.log.size() == n_log);
    }
}

TEST_CASE("a failed transfer at any step costs one attempt, an unplugged device ends it at once") {
    const bool gone = GENERATE(true, false);
    for (std::size_t n = 0; n < 21; ++n) {
        Session s;
        s.device.image = container(100);
        REQUIRE(s.start(Session::config_for(s.device.image)) == PAL_FALCON_OK);
        REQUIRE(s.run([&] { return s.device.log.size() >= n + 1; }));
        pal_falcon_transfer_failed(&s.falcon, gone, s.now_us);
        if (gone) {
            CHECK(s.falcon.state == PAL_FALCON_FAULT);
            CHECK(s.status().failure == PAL_FAIL_UNPLUGGED);
            for (int k = 0; k < 100; ++k) s.step();
            CHECK(s.device.log.size() == n + 1);
            CHECK(pal_falcon_done(&s.falcon));
        } else {
            s.device.waiting().clear();
            REQUIRE(s.run_to(PAL_FALCON_HOMING));
            CHECK(s.status().attempt == 2);
        }
    }
}

TEST_CASE("transfers that fail after the upload are named so, and not a fault of the firmware") {
    Session s;
    pal_falcon_config config = once(s.device.image);
    const bool probes = GENERATE(false, true);
    if (probes) config.boot.reload = PAL_RELOAD_NEVER;
    REQUIRE(s.start(config) == PAL_FALCON_OK);
    REQUIRE(s.run([&] { return s.falcon.boot.stage == PAL_STAGE_FIRST_REPLY; }));
    s.device.waiting().clear();
    for (int k = 0; k < 100 && s.falcon.state == PAL_FALCON_BOOTING; ++k) {
        const pal_usb_step step = pal_falcon_next(&s.falcon, ++s.now_us);
        if (step.kind == PAL_USB_WRITE) pal_falcon_transfer_failed(&s.falcon, false, s.now_us);
        if (step.kind == PAL_USB_IDLE) s.now_us += step.wake_us;
    }
    CHECK(s.falcon.state == PAL_FALCON_FAULT);
    CHECK(s.status().failure == PAL_FAIL_TRANSFER);
    CHECK(s.status().at_stage == PAL_STAGE_FIRST_REPLY);
}

TEST_CASE("an image that is no boot container is refused before a byte is sent") {
    Session s;
    Bytes bad = container(10);
    bad.pop_back();
    CHECK(s.start(Session::config_for(bad)) == PAL_FALCON_REFUSE_IMAGE);
    CHECK(s.start(pal_falcon_config_default()) == PAL_FALCON_REFUSE_NO_IMAGE);
    for (int k = 0; k < 10; ++k) s.step();
    CHECK(s.device.log.empty());
    CHECK(s.falcon.state == PAL_FALCON_CLOSED);
    CHECK(pal_falcon_done(&s.falcon));
}

TEST_CASE("a setting out of its range is refused") {
    const Bytes image = container();
    const pal_falcon_config good = Session::config_for(image);
    pal_falcon f;
    REQUIRE(pal_falcon_init(&f, &good) == PAL_FALCON_OK);
    const std::array<std::function<void(pal_falcon_config&)>, 16> spoil{
        [](auto& c) { c.delta = nullptr; },
        [](auto& c) { c.boot.n_attempts = 0; },
        [](auto& c) { c.boot.n_bauds = 0; },
        [](auto& c) { c.boot.n_bauds = 5; },
        [](auto& c) { c.boot.bauds[1] = 100; },
        [](auto& c) { c.boot.n_asks = 0; },
        [](auto& c) { c.boot.n_first = 0; },
        [](auto& c) { c.boot.run_latency_ms = 0; },
        [](auto& c) { c.boot.echo_wait_us = 4000000000U; },
        [](auto& c) { c.force.force_max_n = 9.0F; },
        [](auto& c) { c.force.force_max_n = NAN; },
        [](auto& c) { c.force.rms_time_s = 0.0F; },
        [](auto& c) { c.n_stop_packets = 2; },
        [](auto& c) { c.n_silent_max = 0; },
        [](auto& c) { c.pose.velocity_cutoff_hz = NAN; },
        [](auto& c) { c.exchange.reply_wait_us = 4000000000U; },
    };
    for (const auto& one : spoil) {
        pal_falcon_config config = good;
        one(config);
        CHECK(pal_falcon_init(&f, &config) == PAL_FALCON_REFUSE_CONFIG);
        CHECK(f.state == PAL_FALCON_CLOSED);
    }
}

TEST_CASE("stopping a boot ends it at once") {
    Session s;
    REQUIRE(s.start(Session::config_for(s.device.image)) == PAL_FALCON_OK);
    for (int k = 0; k < 14; ++k) s.step();
    const std::size_t n_log = s.device.log.size();
    pal_falcon_stop(&s.falcon);
    CHECK(s.falcon.state == PAL_FALCON_CLOSED);
    for (int k = 0; k < 20; ++k) s.step();
    CHECK(s.device.log.size() == n_log);
}
