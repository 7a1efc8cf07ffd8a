// The driver on 1 ms USB frames, in virtual time: how many exchanges a second, and against the simplest loop.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <memory>

#include "firmware/falcon/falcon.h"
#include "sim/usb/device_port.h"
#include "tests/sim/plain_host.hpp"

namespace {

/// What libusb and the kernel are to the driver: transfers in frames, three reads posted ahead.
class FramePort {
public:
    explicit FramePort(const pal_falcon_config& config) {
        pal_usb_device_config device = pal_usb_device_config_default();
        device.falcon.n_substeps = 1;
        device.loader.autobaud_fail_per_million = 0;
        REQUIRE(pal_usb_device_init(device_.get(), &device));
        const pal_host_device wire = pal_host_device_of(device_.get());
        pal_host_init(&host_, &wire, PAL_HOST_FRAMES, 1);
        for (int i = 0; i < N_READS; ++i) {
            reads_[i].endpoint = PAL_USB_EP_IN;
            reads_[i].data = bytes_[i];
            reads_[i].n_bytes = sizeof bytes_[i];
            REQUIRE(pal_host_submit(&host_, &reads_[i], 0) == PAL_HOST_OK);
        }
        REQUIRE(pal_falcon_init(&falcon, &config) == PAL_FALCON_OK);
    }

    /// Until `until_us` of virtual time.
    void run(uint64_t until_us) {
        while (now_us < until_us) {
            const bool idle = !busy_ && !submit(pal_falcon_next(&falcon, now_us));
            uint64_t next_us = pal_host_next_us(&host_);
            if (idle) next_us = std::min(next_us, now_us + wake_us_);
            now_us = std::max(now_us, std::min(next_us, until_us));
            pal_host_advance(&host_, now_us);
            reap();
        }
    }

    pal_falcon falcon{};
    uint64_t now_us = 0;

private:
    static constexpr int N_READS = 3;

    /// False: there was nothing to do.
    bool submit(const pal_usb_step& step) {
        if (step.kind == PAL_USB_IDLE) {
            wake_us_ = step.wake_us;
            return false;
        }
        write_ = pal_urb{};
        if (step.kind == PAL_USB_CONTROL) {
            const uint8_t setup[8] = {PAL_FTDI_REQUEST_TYPE,
                                      step.request,
                                      static_cast<uint8_t>(step.value & 0xFFU),
                                      static_cast<uint8_t>(step.value >> 8U),
                                      static_cast<uint8_t>(step.index & 0xFFU),
                                      static_cast<uint8_t>(step.index >> 8U),
                                      0,
                                      0};
            std::memcpy(write_.setup, setup, sizeof setup);
        } else {
            std::memcpy(out_, step.bytes, step.n_bytes);
            write_.endpoint = PAL_USB_EP_OUT;
            write_.data = out_;
            write_.n_bytes = static_cast<uint32_t>(step.n_bytes);
        }
        REQUIRE(pal_host_submit(&host_, &write_, now_us) == PAL_HOST_OK);
        busy_ = true;
        return true;
    }

    void reap() {
        for (pal_urb* urb = pal_host_reap(&host_); urb != nullptr; urb = pal_host_reap(&host_)) {
            REQUIRE(urb->status == PAL_HOST_OK);
            if (urb == &write_) {
                busy_ = false;
                continue;
            }
            pal_falcon_feed(&falcon, urb->data, urb->n_done, now_us);
            REQUIRE(pal_host_submit(&host_, urb, now_us) == PAL_HOST_OK);
        }
    }

    std::unique_ptr<pal_usb_device> device_ = std::make_unique<pal_usb_device>();
    pal_host host_{};
    pal_urb reads_[N_READS] = {};
    uint8_t bytes_[N_READS][64];
    pal_urb write_{};
    uint8_t out_[64];
    bool busy_ = false;
    uint64_t wake_us_ = 0;
};

pal_falcon_config config_for(const palpate::test::Bytes& image) {
    pal_falcon_config config = pal_falcon_config_default();
    config.boot.image = image.data();
    config.boot.n_image_bytes = image.size();
    return config;
}

/// Replies within `for_us` of virtual time, after one second for boot and first replies.
uint32_t n_replies(FramePort& port, uint64_t for_us) {
    port.run(1000000);
    pal_falcon_sense before;
    pal_falcon_read(&port.falcon, &before);
    REQUIRE(before.n_exchanges > 0);
    port.run(1000000 + for_us);
    pal_falcon_sense after;
    pal_falcon_read(&port.falcon, &after);
    CHECK(after.n_timeouts == 0);
    CHECK(after.n_unasked == 0);
    return after.n_exchanges - before.n_exchanges;
}

TEST_CASE("in 60 s of 1 ms frames the driver misses none: 60000 exchanges, twice a loop of write and read") {
    const palpate::test::Bytes image = palpate::test::boot_image(50);
    FramePort port(config_for(image));
    // A loop that writes, then posts its read, takes two frames (test "a Falcon in frames: write, then read
    // takes 2 ms, as measured with real ones").
    CHECK(n_replies(port, 60000000) == 60000);
}

TEST_CASE("without the event character some replies miss their frame by the bridge's 1 ms timer") {
    const palpate::test::Bytes image = palpate::test::boot_image(50);
    pal_falcon_config config = config_for(image);
    config.boot.event_char = false;
    config.boot.run_latency_ms = 1;
    FramePort port(config);
    const uint32_t n = n_replies(port, 10000000);
    CHECK(n > 8500);
    CHECK(n < 9900);
}

}  // namespace
