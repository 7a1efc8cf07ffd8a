// The driver against the simulated device, in virtual time: it fails at every stage of the boot, at every
// byte of the upload, under every option of the loader. The driver boots within its attempts or names the
// stage, and no force is left on.
#include <array>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <random>

#include "tests/sim/driver_rig.hpp"

namespace {

using palpate::test::Rig;

constexpr std::uint64_t FOREVER_US = 1000000000;

pal_usb_fault boot_fault(int stage, std::uint32_t byte, bool once) {
    pal_usb_fault fault = pal_usb_fault_of(PAL_USB_FAULT_BOOT_FAIL);
    fault.stage = static_cast<std::uint8_t>(stage);
    fault.byte = byte;
    if (once)
        fault.n = 1;
    else
        fault.for_us = FOREVER_US;
    return fault;
}

pal_falcon_failure name_of(int stage) {
    switch (stage) {
        case PAL_BOOT_FAIL_PIC_SILENT:
        case PAL_BOOT_FAIL_PIC_WRONG:
            return PAL_FAIL_NO_PIC;
        case PAL_BOOT_FAIL_AUTOBAUD_SILENT:
        case PAL_BOOT_FAIL_AUTOBAUD_WRONG:
            return PAL_FAIL_NO_AUTOBAUD;
        case PAL_BOOT_FAIL_ECHO_WRONG:
            return PAL_FAIL_ECHO_WRONG;
        case PAL_BOOT_FAIL_ECHO_SILENT:
            return PAL_FAIL_ECHO_TIMEOUT;
        default:
            return PAL_FAIL_NO_REPLY;
    }
}

}  // namespace

TEST_CASE("the simulated device boots at the first attempt under every option of its loader") {
    for (unsigned option = 0; option < 16; ++option) {
        CAPTURE(option);
        Rig rig;
        rig.device_config.loader.zero_before_answer = (option & 1U) != 0;
        rig.device_config.loader.xoff_before_echo = (option & 2U) != 0;
        rig.device_config.running = (option & 4U) != 0;
        rig.config.boot.event_char = (option & 8U) != 0;
        rig.start({});
        rig.run(50000);
        CHECK(rig.falcon.state == PAL_FALCON_HOMING);
        CHECK(rig.status().attempt == 1);
        CHECK(rig.truth().running);
        CHECK(rig.truth().homing);
        CHECK(rig.falcon.exchange.n_timeouts <= 1);  // the firmware may still be starting
        CHECK(rig.falcon.exchange.n_replies > 20);
        rig.stop();
        rig.check_no_force();
    }
}

TEST_CASE("under every combination of what nobody knows the device is booted, homed, pushed and let go") {
    for (unsigned option = 0; option < 3 * 128; ++option) {
        CAPTURE(option);
        const auto on = [&](unsigned bit) { return (option % 128 & 1U << bit) != 0; };
        Rig rig;
        rig.device_config.loader.zero_before_answer = on(0);
        rig.device_config.loader.xoff_before_echo = on(1);
        rig.device_config.running = on(2);
        rig.device_config.falcon.homed_needs_bit = on(3);
        rig.device_config.falcon.reply_spare = on(4) ? 15 : 0;
        rig.device_config.falcon.watchdog_ticks = std::array{5U, 100U, 100000U}[option / 128];
        rig.device_config.falcon.start_m[2] = 0.076;  // at the inner stop, and it stays there
        rig.device_config.falcon.coulomb_n = 20.0;
        rig.config.boot.event_char = on(5);
        rig.config.keep_homing_bit = on(6);
        rig.config.force.ramp_us = 1000;
        rig.start({});
        const std::array<float, 3> force_n{0.0F, 0.0F, -1.0F};
        while (rig.now_us < 400000 && rig.truth().motor_counts[0] == 0) {
            rig.step();
            pal_falcon_drive(&rig.falcon, force_n.data(), 8.0F, 0);
        }
        CHECK(rig.falcon.state == PAL_FALCON_READY);
        CHECK(rig.status().attempt == 1);
        CHECK(rig.truth().motor_counts[0] != 0);
        rig.stop();
        rig.check_no_force();
    }
}

TEST_CASE("a boot that fails once, at any stage and byte, succeeds within the attempts") {
    const int stage = GENERATE(range(1, 8));
    const bool at_bytes = stage == PAL_BOOT_FAIL_ECHO_WRONG || stage == PAL_BOOT_FAIL_ECHO_SILENT;
    for (unsigned option = 0; option < 4; ++option) {
        for (std::uint32_t byte = 0; byte < (at_bytes ? Rig().n_image_bytes() : 1); ++byte) {
            Rig rig;
            rig.device_config.loader.zero_before_answer = (option & 1U) != 0;
            rig.device_config.loader.xoff_before_echo = (option & 2U) != 0;
            rig.start({boot_fault(stage, byte, true)});
            rig.run(2000);
            CAPTURE(stage, byte, option);
            REQUIRE(rig.truth().n_strikes == 1);
            REQUIRE(rig.falcon.state == PAL_FALCON_HOMING);
            // A question to the PIC is asked again within the attempt.
            REQUIRE(rig.status().attempt == (stage <= PAL_BOOT_FAIL_PIC_WRONG ? 1U : 2U));
            rig.check_no_force();
        }
    }
}

TEST_CASE("a boot that always fails is named, with its byte, in bounded time, without any force") {
    const int stage = GENERATE(range(1, 8));
    const bool at_bytes = stage == PAL_BOOT_FAIL_ECHO_WRONG || stage == PAL_BOOT_FAIL_ECHO_SILENT;
    for (std::uint32_t byte = 0; byte < (at_bytes ? Rig().n_image_bytes() : 1); ++byte) {
        Rig rig;
        rig.start({boot_fault(stage, byte, false)});
        rig.run(2000, 5000000);
        CAPTURE(stage, byte);
        REQUIRE(rig.falcon.state == PAL_FALCON_FAULT);
        REQUIRE(rig.status().failure == name_of(stage));
        REQUIRE(rig.status().attempt == 3);
        if (at_bytes) REQUIRE(rig.status().failed_byte == byte);
        REQUIRE(pal_falcon_done(&rig.falcon));
        rig.check_no_force();
    }
}

TEST_CASE("a supply that fails for 50 ms at any moment of the boot costs attempts, not the boot") {
    for (std::uint64_t at_us = 0; at_us < 150000; at_us += 3700) {
        Rig rig;
        pal_usb_fault fault = pal_usb_fault_of(PAL_USB_FAULT_POWER_OUT);
        fault.at_us = at_us;
        fault.for_us = 50000;
        rig.start({fault});
        rig.run(300000);
        CAPTURE(at_us, rig.status().failure, rig.status().attempt);
        // After the boot it is a device that fell silent: a fault by name, to be started again.
        if (rig.falcon.state == PAL_FALCON_FAULT)
            CHECK(rig.status().failure == PAL_FAIL_SILENT);
        else
            CHECK(rig.falcon.state == PAL_FALCON_HOMING);
        rig.check_no_force();
    }
}

TEST_CASE("a plug pulled at any moment of the boot is named at once") {
    for (std::uint64_t at_us = 0; at_us < 150000; at_us += 3700) {
        Rig rig;
        pal_usb_fault fault = pal_usb_fault_of(PAL_USB_FAULT_UNPLUG);
        fault.at_us = at_us;
        fault.for_us = FOREVER_US;
        rig.start({fault});
        rig.run(200000);
        CAPTURE(at_us);
        CHECK(rig.falcon.state == PAL_FALCON_FAULT);
        CHECK(rig.status().failure == PAL_FAIL_UNPLUGGED);
        rig.check_no_force();
    }
}

TEST_CASE("a homed device gets the force that was asked for, and none after every way to end") {
    const int ending = GENERATE(range(0, 4));
    Rig rig;
    rig.device_config.falcon.start_m[2] = 0.076;      // at the inner stop: homed as soon as homing is on
    rig.device_config.falcon.gravity_m_per_s2 = 0.0;  // or it falls while it boots
    rig.config.force.ramp_us = 0;
    rig.start({});
    const std::array<float, 3> force_n{1.0F, -1.0F, -2.0F};
    const auto drive_for = [&](std::uint64_t us) {
        const std::uint64_t until_us = rig.now_us + us;
        while (rig.now_us < until_us) {
            rig.step();
            if (ending != 3 || rig.now_us + us / 2 < until_us) {
                pal_falcon_drive(&rig.falcon, force_n.data(), 8.0F, 0);
            }
        }
    };
    rig.run(20000);
    REQUIRE(rig.falcon.state == PAL_FALCON_READY);
    drive_for(ending == 3 ? 20000 : 40000);
    if (ending != 3) {
        for (std::size_t c = 0; c < 3; ++c) {
            CHECK(rig.truth().force_n[c] ==
                  Approx(static_cast<double>(force_n[c])).margin(0.05));  // moves on within a tick
        }
    }
    if (ending == 0) {
        rig.stop();
        CHECK(rig.falcon.state == PAL_FALCON_CLOSED);
    } else if (ending == 1) {  // the supply fails: motors cannot hold, and the driver says so
        pal_usb_fault fault = pal_usb_fault_of(PAL_USB_FAULT_POWER_OUT);
        fault.for_us = FOREVER_US;
        REQUIRE(pal_usb_device_inject(rig.device(), &fault));
        drive_for(500000);
        CHECK(rig.status().failure == PAL_FAIL_SILENT);
    } else if (ending == 2) {  // replies are lost, requests are not: the zero words still arrive
        pal_usb_fault fault = pal_usb_fault_of(PAL_USB_FAULT_DROP);
        fault.dir = PAL_USB_FAULT_IN;
        fault.for_us = FOREVER_US;
        REQUIRE(pal_usb_device_inject(rig.device(), &fault));
        drive_for(500000);
        CHECK(rig.status().failure == PAL_FAIL_SILENT);
    } else {  // the caller falls asleep, its port does not
        drive_for(200000);
        CHECK((rig.falcon.faults_seen & PAL_FALCON_DRIVE_STALE) != 0);
    }
    rig.check_no_force();
}

TEST_CASE(
    "a plug pulled at a random moment stops the driver at zero force, and it goes on after boot and homing") {
    const int n_times = std::getenv("PALPATE_SOAK") != nullptr ? 500 : 50;
    std::mt19937_64 random(1);
    int n_driven = 0;
    for (int time = 0; time < n_times; ++time) {
        Rig rig;
        rig.device_config.falcon.start_m[2] = 0.076;  // at the inner stop: homed as soon as homing is on
        rig.device_config.falcon.gravity_m_per_s2 = 0.0;
        rig.device_config.falcon.n_substeps =
            pal_falcon_sim_config_default().n_substeps;  // leans on the stop
        rig.config.force.ramp_us = 10000;
        pal_usb_fault fault = pal_usb_fault_of(PAL_USB_FAULT_UNPLUG);
        fault.at_us = 1 + random() % 300000;
        fault.for_us = 20000 + random() % 200000;
        CAPTURE(fault.at_us, fault.for_us);
        rig.start({fault});
        const std::array<float, 3> force_n{0.0F, 0.0F,
                                           -1.0F};  // against the stop, or it could not home again
        const auto drive_until = [&](std::uint64_t us) {
            while (rig.now_us < us && rig.falcon.state != PAL_FALCON_FAULT) {
                rig.step();
                pal_falcon_drive(&rig.falcon, force_n.data(), 8.0F, 0);
            }
        };
        drive_until(fault.at_us + 50000);
        CHECK(rig.falcon.state == PAL_FALCON_FAULT);
        CHECK(rig.status().failure == PAL_FAIL_UNPLUGGED);
        n_driven += rig.falcon.exchange.n_replies > 20;
        CHECK(rig.now_us < fault.at_us + 5000);  // it is known at the next transfer, not after a time-out
        // The motors are let go by the device's watchdog at the latest; then the plug comes back.
        const std::uint64_t back_us = fault.at_us + fault.for_us;
        rig.wait_until(fault.at_us + std::min<std::uint64_t>(fault.for_us, 110000));
        if (fault.for_us > 105000) {
            for (const std::int16_t word : rig.truth().motor_counts) CHECK(word == 0);
        }
        rig.wait_until(back_us + 1000);
        REQUIRE(pal_falcon_init(&rig.falcon, &rig.config) == PAL_FALCON_OK);
        drive_until(rig.now_us + 400000);
        CHECK(rig.falcon.state == PAL_FALCON_READY);
        CHECK(rig.falcon.force.words[0] != 0);
        rig.stop();
        rig.check_no_force();
    }
    CHECK(n_driven > n_times / 3);
}

TEST_CASE("an autobaud that fails three times in four is helped by the slower rates") {
    int n_booted = 0;
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
        Rig rig;
        rig.device_config.seed = seed;
        rig.device_config.loader.autobaud_fail_per_million = 750000;
        rig.config.boot.n_attempts = 6;
        rig.start({});
        rig.run(2000);
        n_booted += rig.falcon.state == PAL_FALCON_HOMING ? 1 : 0;
        if (rig.falcon.state == PAL_FALCON_HOMING) CHECK(rig.status().attempt <= 4);  // 57554 always locks
    }
    CHECK(n_booted == 50);
}
