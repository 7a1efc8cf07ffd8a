/// The driver and the simulated device in virtual time, with what libusb would be between them.
#pragma once
#include <catch2/catch.hpp>
#include <cstdlib>
#include <memory>
#include <vector>

#include "firmware/falcon/falcon.h"
#include "tests/sim/plain_host.hpp"

namespace palpate::test {

inline constexpr std::uint64_t TRANSFER_US = 125;  ///< of a control request or write

/// Carries out the driver's steps on the device.
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

    /// Time passes, and the driver does not look.
    void wait_until(std::uint64_t us) { advance(std::max(us, now_us)); }

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
    /// 130 bytes: 62 + 62 + 6; with PALPATE_SOAK 1000.
    Bytes image_ = boot_image(std::getenv("PALPATE_SOAK") != nullptr ? 485 : 50);
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

}  // namespace palpate::test
