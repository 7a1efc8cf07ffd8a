// Any bytes at any time to the driver of the Falcon, in every state: each step it asks for is one that a port
// can do, no force goes out unless it is ready, and it always comes to an end when it is told to.
#include "firmware/falcon/falcon.h"

#include <cmath>

#include "tests/fuzz/input.hpp"

namespace {

using fuzz::require;

fuzz::Reached homing("homing"), ready("ready"), forces("request with a force"), faults("fault"),
    attempts("second attempt");

const std::uint8_t IMAGE[] = {0xAA, 0x08, 0,    0,    0,    0,    0,    0,    0,    0,    0,
                              0,    0,    0,    0,    0,    0,    0,    0x3F, 0x00, 0x02, 0x80,
                              0x01, 0x00, 0x3F, 0x00, 0x02, 0x80, 0x00, 0x00, 0x00, 0x00};

class Port {
public:
    explicit Port(std::uint8_t options) {
        pal_falcon_config config = pal_falcon_config_default();
        config.boot.image = IMAGE;
        config.boot.n_image_bytes = sizeof IMAGE;
        config.boot.reload = static_cast<pal_reload>(options % 3U);
        config.boot.event_char = (options & 4U) != 0;
        config.needs_homing = (options & 8U) != 0;
        config.keep_homing_bit = (options & 16U) != 0;
        config.force.ramp_us = (options & 32U) != 0 ? 0 : 5000;
        config.n_silent_max = 3;
        config.boot.n_attempts = 2;
        config.boot.n_asks = 2;
        config.boot.n_first = 2;
        config.trace = &trace_;
        require(pal_falcon_init(&falcon, &config) == PAL_FALCON_OK);
    }

    /// All steps until there is nothing to send.
    void pump() {
        for (int n = 0; n < 64; ++n) {
            const pal_usb_step step = pal_falcon_next(&falcon, now_us);
            if (step.kind == PAL_USB_IDLE) {
                require(step.wake_us > 0 && step.wake_us <= 1000000);
                wake_us = step.wake_us;
                return;
            }
            check(step);
            now_us += 50;
        }
        require(false);
    }

    /// What a good device would say to the last write.
    std::size_t good_answer(std::uint8_t flags, std::uint8_t out[64]) const {
        std::size_t n = 0;
        out[n++] = 0x01;
        out[n++] = 0x60;
        if (n_sent_ == 3) {
            for (const int b : {0x0A, 0x44, 0x2C, 0x0D}) out[n++] = static_cast<std::uint8_t>(b);
        } else if (n_sent_ == 16 && sent_[0] == '<') {
            out[n++] = '<';
            for (int i = 0; i < 3; ++i) {  // -516: (0, 0, 0.11) m
                for (const char c : {'M', 'P', 'N', 'P'}) out[n++] = static_cast<std::uint8_t>(c);
            }
            out[n++] = static_cast<std::uint8_t>(0x41 + (flags & 0x7FU));
            out[n++] = 'A';
            out[n++] = '>';
        } else {
            std::memcpy(out + n, sent_, n_sent_);
            n += n_sent_;
        }
        return n;
    }

    void check_sense() const {
        pal_falcon_sense sense;
        const pal_falcon_state state = pal_falcon_read(&falcon, &sense);
        for (int c = 0; c < 3; ++c) {
            require(std::isfinite(sense.position_m[c]) && std::isfinite(sense.velocity_m_per_s[c]));
            require(std::isfinite(sense.force_n[c]) && std::fabs(sense.force_n[c]) <= 8.001F);
        }
        char text[96];
        require(pal_falcon_describe(&falcon, text, sizeof text) < sizeof text);
        if (state == PAL_FALCON_HOMING) homing.note();
        if (state == PAL_FALCON_READY) ready.note();
        if (state == PAL_FALCON_FAULT) faults.note();
        if (falcon.boot.attempt > 1) attempts.note();
    }

    pal_falcon falcon;
    std::uint64_t now_us = 1;
    std::uint32_t wake_us = 1;

private:
    std::uint8_t sent_[64] = {};
    std::size_t n_sent_ = 0;
    pal_falcon_trace_record records_[7];
    pal_falcon_trace trace_{records_, 7, 0};

    void check(const pal_usb_step& step) {
        if (step.kind == PAL_USB_CONTROL) {
            require(step.request <= 9 && step.request != 5 && step.request != 8);
            return;
        }
        require(step.kind == PAL_USB_WRITE && step.n_bytes >= 1 && step.n_bytes <= 62);
        std::memcpy(sent_, step.bytes, step.n_bytes);
        n_sent_ = step.n_bytes;
        if (falcon.state == PAL_FALCON_BOOTING && falcon.boot.stage != PAL_STAGE_FIRST_REPLY) return;
        require(step.n_bytes == 16 && sent_[0] == '<' && sent_[15] == '>');
        bool force = false;
        for (std::size_t i = 1; i <= 12; ++i) force = force || sent_[i] != 'A';
        if (!force) return;
        require(falcon.state == PAL_FALCON_READY && falcon.pose.has_position);
        forces.note();
        for (const std::int16_t word : falcon.force.words) require(word >= -4095 && word <= 4095);
    }
};

void feed(Port& port, const std::uint8_t* packet, std::size_t n) {
    pal_falcon_feed(&port.falcon, packet, n, port.now_us);
}

void act(Port& port, fuzz::Bytes& in) {
    const auto what = fuzz::take<std::uint8_t>(in);
    std::uint8_t packet[64];
    if (what < 120) {  // the usual; some of the flags come from the input
        const std::size_t n = port.good_answer(what < 100 ? 0x70 : static_cast<std::uint8_t>(what), packet);
        feed(port, packet, n);
        const float force_n[3] = {0.0F, 1.0F, -3.0F};
        pal_falcon_drive(&port.falcon, force_n, 8.0F, what);
    } else if (what < 150) {  // spoilt
        const std::size_t n = port.good_answer(0x70, packet);
        const auto at = fuzz::take<std::uint8_t>(in);
        packet[at % n] = fuzz::take<std::uint8_t>(in);
        feed(port, packet, at % 7 == 0 ? at % n : n);
    } else if (what < 190) {
        const std::size_t n = std::min<std::size_t>(in.size(), what - 150U);
        feed(port, in.data(), n);
        in = in.subspan(n);
    } else if (what < 220) {
        port.now_us += port.wake_us;
    } else if (what < 230) {
        port.now_us += fuzz::take<std::uint32_t>(in) % 3000000U;
    } else if (what < 245) {
        const auto force = fuzz::take<std::array<float, 4>>(in);
        pal_falcon_drive(&port.falcon, force.data(), force[3], what);
    } else if (what < 250) {
        pal_falcon_transfer_failed(&port.falcon, false, port.now_us);
    } else if (what == 254) {
        pal_falcon_transfer_failed(&port.falcon, true, port.now_us);
    } else if (what == 255) {
        pal_falcon_stop(&port.falcon);
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Bytes in{data, size};
    Port port(fuzz::take<std::uint8_t>(in));
    port.pump();
    while (!in.empty()) {
        act(port, in);
        port.pump();
        port.check_sense();
    }
    pal_falcon_stop(&port.falcon);
    for (int n = 0; n < 200 && !pal_falcon_done(&port.falcon); ++n) {
        port.pump();
        port.now_us += port.wake_us;
    }
    require(pal_falcon_done(&port.falcon));
    return 0;
}
