#include "firmware/falcon/exchange.h"

static void give_up(pal_exchange* x) {
    x->n_timeouts += 1U;
    x->n_silent += 1U;
    x->phase = PAL_EXCHANGE_PURGE_OUT;
}

void pal_exchange_broken(pal_exchange* x) {
    give_up(x);
}

static bool late(uint64_t now_us, uint64_t deadline_us) {
    return now_us >= deadline_us;
}

// Waits that begin when the step before them is done.
static void arm(const pal_exchange_config* config, pal_exchange* x, uint64_t now_us) {
    if (x->phase == PAL_EXCHANGE_SENT) {
        x->phase = PAL_EXCHANGE_WAIT;
        x->deadline_us = now_us + config->reply_wait_us;
    } else if (x->phase == PAL_EXCHANGE_PURGED) {
        x->phase = PAL_EXCHANGE_DRAIN;
        x->deadline_us = now_us + config->drain_us;
    }
}

pal_usb_step pal_exchange_next(const pal_exchange_config* config, pal_exchange* x, uint64_t now_us,
                               bool* wants_request) {
    *wants_request = false;
    arm(config, x, now_us);
    if (x->phase == PAL_EXCHANGE_WAIT || x->phase == PAL_EXCHANGE_DRAIN) {
        if (!late(now_us, x->deadline_us)) return pal_ftdi_idle((uint32_t)(x->deadline_us - now_us));
        if (x->phase == PAL_EXCHANGE_WAIT)
            give_up(x);
        else
            x->phase = PAL_EXCHANGE_FREE;
    }
    if (x->phase == PAL_EXCHANGE_PURGE_OUT) {
        x->phase = PAL_EXCHANGE_PURGE_IN;
        return pal_ftdi_control(PAL_FTDI_RESET, PAL_FTDI_PURGE_OUT);
    }
    if (x->phase == PAL_EXCHANGE_PURGE_IN) {
        x->phase = PAL_EXCHANGE_PURGED;
        x->reader.n_bytes = 0;
        return pal_ftdi_control(PAL_FTDI_RESET, PAL_FTDI_PURGE_IN);
    }
    if (!late(now_us, x->due_us)) return pal_ftdi_idle((uint32_t)(x->due_us - now_us));
    *wants_request = true;
    return pal_ftdi_idle(0);
}

pal_usb_step pal_exchange_send(const pal_exchange_config* config, pal_exchange* x, uint64_t now_us,
                               const pal_wire_request* request) {
    pal_packet_encode(request, x->packet);
    const bool in_step = now_us - x->due_us < config->period_us;  // else missed periods are not made up for
    x->due_us = (in_step ? x->due_us : now_us) + config->period_us;
    x->n_requests += 1U;
    x->phase = PAL_EXCHANGE_SENT;
    pal_usb_step step = {PAL_USB_WRITE, 0, 0, 0, x->packet, PAL_WIRE_BYTES, 0};
    return step;
}

bool pal_exchange_feed(pal_exchange* x, const uint8_t* bytes, size_t n_bytes, pal_wire_reply* reply) {
    const bool asked = x->phase == PAL_EXCHANGE_SENT || x->phase == PAL_EXCHANGE_WAIT;
    if (!asked && x->phase != PAL_EXCHANGE_FREE) return false;  // stale: what the purge was for
    uint32_t n_whole = 0;
    for (size_t i = 0; i < n_bytes; ++i) {
        if (!pal_wire_feed(&x->reader, bytes[i])) continue;
        if (pal_packet_decode(x->reader.bytes, reply))
            n_whole += 1U;
        else
            x->reader.n_skipped_bytes += PAL_WIRE_BYTES;
    }
    if (n_whole == 0) return false;
    const uint32_t n_asked = asked ? 1U : 0U;
    x->n_unasked += n_whole - n_asked;
    x->phase = n_whole > n_asked ? PAL_EXCHANGE_PURGE_OUT : PAL_EXCHANGE_FREE;
    if (!asked) return false;
    x->n_replies += 1U;
    x->n_silent = 0;
    return true;
}
