// The driver against the simulated device, in virtual time: it fails at every stage of the boot, at every
// byte of the upload, under every option of the loader. The driver boots within its attempts or names the
// stage, and no force is left on.
#include <array>
#include <catch2/catch.hpp>
#include <memory>

#include "firmware/falcon/falcon.h"
#include "tests/sim/plain_host.hpp"

namespace {

using palpate::test::boot_image;
using palpate::test::Bytes;

constexpr std::uint64_t TRANSFER_US = 125;  // of a control request or write
constexpr std::uint64_t FOREVER_US = 1000000000;

// What libusb would be: carries out the driver's steps on the device.
class Rig {
public:
    pal_usb_device_config device_config = pal_usb_device_config_default();
    pal_falcon_config config = pal_falcon_config_default();
    pal_falcon falcon{};
    std::uint64_t now_us = 0;

    Rig() {
        device_config.falcon.n_substeps = 1;  // the mechanics matter little here
        device_config.loader.autobaud_fail_per_million = 0;
        config.boot.image = image_.data();
        config.boot.n_image_bytes = image_.size();
        config.boot.n_attempts = 3;
        config.boot.n_asks = 3;
        config.boot.n_first = 3;
    }

    void start(const std::vector<pal_usb_fault>& faults) {
        device_config.faults = faults.data();
        device_config.n_faults = faults.size();
        REQUIRE(pal_usb_device_init(device_.get(), &device_config));
        REQUIRE(pal_falcon_init(&falcon, &config) == PAL_FALCON_OK);
    }

    /// Until the boot ended, well or not, and for `more_us` beyond.
    void run(std::uint64_t more_us, std::uint64_t limit_us = 20000000) {
        const std::uint64_t limit = now_us + limit_us;
        std::uint64_t end = limit;
        while (now_us < end) {
            step();
            if (end == limit && falcon.state != PAL_FALCON_BOOTING) end = now_us + more_us;
        }
        REQUIRE(falcon.state != PAL_FALCON_BOOTING);
    }

    void stop() {
        pal_falcon_stop(&falcon);
        for (int n = 0; n < 5000 && !pal_falcon_done(&falcon); ++n) step();
        REQUIRE(pal_falcon_done(&falcon));
        advance(now_us + 5000);
    }

    [[nodiscard]] pal_falcon_status status() const {
        pal_falcon_status now;
        pal_falcon_status_read(&falcon, &now);
        return now;
    }
    [[nodiscard]] pal_usb_device_truth truth() const { return pal_usb_device_read(device_.get()); }
    [[nodiscard]] std::size_t n_image_bytes() const { return image_.size(); }
    [[nodiscard]] pal_usb_device* device() { return device_.get(); }

    /// No request ever asked for a force, and none acts.
    void check_no_force() const {
        for (const std::int16_t word : truth().motor_counts) CHECK(word == 0);
        for (const std::int16_t word : falcon.force.words) CHECK(word == 0);
    }

    void step() {
        const pal_usb_step s = pal_falcon_next(&falcon, now_us);
        int result = 0;
        if (s.kind == PAL_USB_CONTROL) {
            const std::uint8_t setup[8] = {PAL_FTDI_REQUEST_TYPE,
                                           s.request,
                                           static_cast<std::uint8_t>(s.value & 0xFFU),
                                           static_cast<std::uint8_t>(s.value >> 8U),
                                           static_cast<std::uint8_t>(s.index & 0xFFU),
                                           static_cast<std::uint8_t>(s.index >> 8U),
                                           0,
                                           0};
            result = pal_usb_device_control(device_.get(), setup, nullptr, 0);
            advance(now_us + TRANSFER_US);
        } else if (s.kind == PAL_USB_WRITE) {
            result = write(s);
            advance(now_us + TRANSFER_US);
        } else {
            result = read(now_us + s.wake_us);
        }
        if (result < 0) pal_falcon_transfer_failed(&falcon, result == PAL_USB_GONE, now_us);
    }

private:
    Bytes image_ = boot_image(50);  // 130 bytes: 62 + 62 + 6
    std::unique_ptr<pal_usb_device> device_ = std::make_unique<pal_usb_device>();

    void advance(std::uint64_t us) {
        now_us = us;
        pal_usb_device_advance(device_.get(), us);
    }

    int write(const pal_usb_step& s) {
        for (int n = 0; n < 1000; ++n) {
            const int result = pal_usb_device_out(device_.get(), s.bytes, s.n_bytes);
            if (result != 0) return result;
            advance(now_us + 100);  // no room yet
        }
        return PAL_USB_STALL;
    }

    int read(std::uint64_t until_us) {
        std::uint8_t packet[PAL_USB_PACKET_BYTES];
        while (now_us < until_us) {
            const int n = pal_usb_device_in(device_.get(), packet);
            if (n < 0) {
                advance(now_us + 1000);
                return n;
            }
            if (n > 0) {
                pal_falcon_feed(&falcon, packet, static_cast<std::size_t>(n), now_us);
                return n;
            }
            const std::uint64_t next_us = std::max(pal_usb_device_next_us(device_.get()), now_us + 1);
            advance(std::min(next_us, until_us));
        }
        return 0;
    }
};

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
