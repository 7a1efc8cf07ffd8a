#include "tests/firmware/falcon_running.hpp"

#include <cmath>

using namespace script;

TEST_CASE("there is no force before homing, and none in the first request after it") {
    Running s(Running::no_ramp());
    s.device.reply = reply(MIDDLE, 0x30);  // two arms
    REQUIRE(s.exchange(200));
    CHECK(s.falcon.state == PAL_FALCON_HOMING);
    CHECK_FALSE(s.sense().has_position);
    for (const std::string& line : lines(s.device.log, "W")) REQUIRE(is_zero(words_of(line)));
    CHECK(s.last().flags == (1 | 8));  // homing, red
    s.device.reply = reply(MIDDLE, HOMED);
    const std::size_t n_before = lines(s.device.log, "W").size();
    REQUIRE(s.exchange(6));
    CHECK(s.falcon.state == PAL_FALCON_READY);
    CHECK(s.sense().has_position);
    const Lines after = lines(s.device.log, "W");
    for (std::size_t k = n_before; k < n_before + 4; ++k) REQUIRE(is_zero(words_of(after[k])));
    REQUIRE(s.exchange(2));
    CHECK_FALSE(is_zero(s.last()));
    CHECK(s.last().flags == (1 | 4));  // the bit is kept, blue
}

TEST_CASE("homed flags count only three replies in a row") {
    Running s;
    for (int k = 0; k < 50; ++k) {
        s.device.reply = reply(MIDDLE, k % 3 == 2 ? 0U : HOMED);
        REQUIRE(s.exchange());
        REQUIRE(s.falcon.state == PAL_FALCON_HOMING);
    }
}

TEST_CASE("the homing bit goes off after homing where that is wanted, and the flags no longer count") {
    pal_falcon_config config = Running::no_ramp();
    config.keep_homing_bit = false;
    Running s(config);
    REQUIRE(s.exchange(10));
    REQUIRE(s.falcon.state == PAL_FALCON_READY);
    CHECK(s.last().flags == 4);
    s.device.reply = reply(MIDDLE, 0);
    REQUIRE(s.exchange(50));
    CHECK(s.falcon.state == PAL_FALCON_READY);
    CHECK_FALSE(is_zero(s.last()));
}

TEST_CASE("with the bit kept, an arm that is no longer homed takes force and position away") {
    Running s(Running::no_ramp());
    REQUIRE(s.exchange(10));
    REQUIRE_FALSE(is_zero(s.last()));
    s.device.reply = reply(MIDDLE, 0x50);
    REQUIRE(s.exchange(4));
    CHECK(s.falcon.state == PAL_FALCON_HOMING);
    CHECK_FALSE(s.sense().has_position);
    REQUIRE(s.exchange(20));
    CHECK(is_zero(s.last()));
    CHECK((s.sense().faults_seen & PAL_FALCON_HOME_LOST) != 0);
}

TEST_CASE("a device used without homing is ready at its first reply") {
    pal_falcon_config config = Running::no_ramp();
    config.needs_homing = false;
    Running s(config);
    s.device.reply = reply(MIDDLE, 0);
    REQUIRE(s.exchange(4));
    CHECK(s.falcon.state == PAL_FALCON_READY);
    CHECK_FALSE(is_zero(s.last()));
    CHECK((s.last().flags & 1) == 0);
}

TEST_CASE("the position is that of the encoders") {
    Running s;
    REQUIRE(s.exchange(10));
    CHECK(s.sense().position_m[0] == Approx(0.0).margin(1e-6));
    CHECK(s.sense().position_m[1] == Approx(0.0).margin(1e-6));
    CHECK(s.sense().position_m[2] == Approx(0.11).margin(2.5e-5));  // half a count
    CHECK(s.sense().encoder_counts[0] == -516);
}

TEST_CASE("a force that is not a number is zero and a fault, and the next good one acts") {
    const float bad = GENERATE(as<float>{}, NAN, INFINITY, -INFINITY);
    const int axis = GENERATE(0, 1, 2, 3);  // 3: the limit
    Running s(Running::no_ramp());
    REQUIRE(s.exchange(20));
    if (axis < 3)
        s.force_n[static_cast<std::size_t>(axis)] = bad;
    else
        s.limit_n = bad;
    REQUIRE(s.exchange(2));
    CHECK(is_zero(s.last()));
    CHECK((s.sense().faults & PAL_FALCON_NOT_FINITE) != 0);
    s.force_n = {0.0F, 0.0F, -2.0F};
    s.limit_n = 8.0F;
    REQUIRE(s.exchange(2));
    CHECK_FALSE(is_zero(s.last()));
}

TEST_CASE("a caller that gives no more forces gets none held beyond the time to live") {
    Running s(Running::no_ramp());
    REQUIRE(s.exchange(20));
    s.drives = false;
    REQUIRE(s.exchange(49));
    CHECK_FALSE(is_zero(s.last()));
    REQUIRE(s.exchange(4));
    CHECK(is_zero(s.last()));
    CHECK((s.sense().faults_seen & PAL_FALCON_DRIVE_STALE) != 0);
    s.drives = true;
    REQUIRE(s.exchange(2));
    CHECK_FALSE(is_zero(s.last()));
}

TEST_CASE("after the start the force grows linearly over the ramp, and again after a time-out") {
    Running s;  // 0.5 s
    REQUIRE(s.exchange(4));
    const double full = 4200.0 * 2.0 / (3.0 * 13.785);  // Jz = 13.785 rad/m at z = 0.11 m, three equal arms
    const auto expect_ramp = [&] {
        REQUIRE(s.exchange(1));
        CHECK(is_zero(s.last()));
        const std::uint64_t from_us = s.falcon.request_us;
        for (int k = 0; k < 600; ++k) {
            REQUIRE(s.exchange(1));
            const double share = std::min(1.0, static_cast<double>(s.falcon.request_us - from_us) / 500000.0);
            for (const int word : s.last().motor)
                REQUIRE(std::abs(word - share * full) <= 0.5 + 1.0e-3 * full);
        }
    };
    expect_ramp();
    const std::size_t n_writes = s.device.n_writes;
    s.device.tamper = [&](std::size_t k, const Bytes&, Bytes& said) {
        if (k == n_writes) said.clear();
    };
    expect_ramp();
}

TEST_CASE("an encoder that jumps takes the force away for that exchange") {
    Running s(Running::no_ramp());
    REQUIRE(s.exchange(20));
    s.device.reply = reply({300, -516, -516}, HOMED);  // 816 counts in 1 ms
    REQUIRE(s.exchange(1));
    CHECK((s.sense().faults & PAL_FALCON_JUMP) != 0);
    CHECK(s.sense().velocity_m_per_s[2] == 0.0F);
    s.step();
    REQUIRE(s.exchange(1));
    CHECK(is_zero(s.last()));
    REQUIRE(s.exchange(2));
    CHECK_FALSE(is_zero(s.last()));
}

TEST_CASE("encoders without a position mean no force and no position") {
    Running s(Running::no_ramp());
    REQUIRE(s.exchange(20));
    for (int count = -516; count > -2000; count -= 200) {
        s.device.reply = reply({count, count, count}, HOMED);
        REQUIRE(s.exchange(1));
    }
    REQUIRE(s.exchange(2));
    CHECK_FALSE(s.sense().has_position);
    CHECK((s.sense().faults & PAL_FALCON_WORKSPACE) != 0);
    CHECK(is_zero(s.last()));
    CHECK(s.falcon.state == PAL_FALCON_READY);
}

TEST_CASE("the caller's LEDs go out, and bits that are none do not") {
    Running s;
    const auto leds = static_cast<std::uint8_t>(GENERATE(2, 4, 8, 6, 14, 0xFF));
    s.leds = leds;
    REQUIRE(s.exchange(10));
    CHECK(s.last().flags == ((leds & 14) | 1));
}

TEST_CASE("motor words given instead of a force go out, within the motor's maximum") {
    Running s(Running::no_ramp());
    s.drives = false;
    REQUIRE(s.exchange(10));
    const std::array<std::int16_t, 3> words{100, -200, 300};
    pal_falcon_drive_counts(&s.falcon, words.data(), 0);
    REQUIRE(s.exchange(2));
    CHECK(s.last().motor == std::array<int, 3>{100, -200, 300});
    const std::array<std::int16_t, 3> wild{8190, -32768, 4095};
    pal_falcon_drive_counts(&s.falcon, wild.data(), 0);
    REQUIRE(s.exchange(2));
    CHECK(s.last().motor == std::array<int, 3>{1024, -4095, 512});  // one scale: 4095 / 32768
    CHECK((s.sense().faults & PAL_FALCON_SATURATED) != 0);
}
