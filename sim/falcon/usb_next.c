// When the device next has something for an IN token.
#include "sim/falcon/usb_device_private.h"

enum { CLOSE = '>' };

/// The first microsecond that does not lie before.
static uint64_t us_of(uint64_t clock) {
    return clock / PAL_UART_CLOCKS_PER_US + (clock % PAL_UART_CLOCKS_PER_US ? 1 : 0);
}

/// How long an end of the line takes for a byte.
static uint64_t byte_clocks(const pal_usb_device* d, uint32_t clocks_per_bit) {
    return d->config.instant ? 0 : (uint64_t)clocks_per_bit * PAL_UART_BITS_PER_BYTE;
}

uint64_t pal_usb_line_end(const pal_usb_device* device, const pal_usb_line_byte* byte, uint64_t from_clock) {
    const uint64_t from = byte->earliest_clock > from_clock ? byte->earliest_clock : from_clock;
    return from + byte_clocks(device, byte->clocks_per_bit);
}

bool pal_usb_usable(const pal_usb_device* device, pal_usb_fault_endpoint endpoint) {
    return device->configuration != 0 && !pal_usb_halted(device, endpoint);
}

/// When the bytes that are on their way from PIC or DSP make an IN packet ready.
static uint64_t said_clock(const pal_usb_device* d) {
    uint64_t end = d->line_clock;
    uint32_t n_in = d->bridge.n_in;
    // A byte that changes may be any byte, and one for the flow control sets others free.
    if (d->n_line > 0 && (pal_usb_corrupts(d) || d->bridge.flow != 0)) return end;
    for (uint32_t i = 0; i < d->n_line; ++i) {
        const pal_usb_line_byte* byte = &d->line[(d->line_at + i) % PAL_USB_LINE_BYTES];
        if (i > 0) end = pal_usb_line_end(d, byte, end);
        if (!pal_uart_same_baud(byte->clocks_per_bit, d->bridge.clocks_per_bit)) return end;  // framing error
        if (++n_in >= PAL_BRIDGE_PAYLOAD_BYTES) return end;
        if (d->bridge.event_on && byte->byte == d->bridge.event && n_in > 1) return end;
    }
    return UINT64_MAX;
}

/// The bit time that PIC or DSP have when they answer; of a ROM that knows none yet, that of the byte.
static uint32_t answer_clocks(const pal_usb_device* d) {
    if (d->loader.dtr) return PAL_UART_PIC_CLOCKS_PER_BIT;
    return d->loader.dsp == PAL_DSP_AUTOBAUD ? d->bridge.sending.clocks_per_bit : d->loader.clocks_per_bit;
}

/// How many bytes the bridge sends before an answer to one of them could make a packet ready.
static uint32_t n_until_answer(const pal_usb_device* d) {
    const pal_bridge* b = &d->bridge;
    const uint32_t n_pending = b->n_out + 1;
    // An answer at another baud than the bridge's is ready with its first byte.
    const bool smooth = b->sending.frame_ok && b->sending.clocks_per_bit == b->clocks_per_bit &&
                        pal_uart_same_baud(answer_clocks(d), b->clocks_per_bit);
    if (!smooth || pal_usb_corrupts(d)) return 1;
    if (d->loader.dsp != PAL_DSP_RUN || d->loader.dtr) {  // at most one byte comes back for each
        const uint32_t n_full = b->n_in + d->n_line + PAL_LOADER_ANSWER_MAX;
        if (b->event_on || n_full >= PAL_BRIDGE_PAYLOAD_BYTES) return 1;
        const uint32_t n_left = PAL_BRIDGE_PAYLOAD_BYTES - n_full;
        return n_left < n_pending ? n_left : n_pending;
    }
    if (b->sending.byte == CLOSE) return 1;
    for (uint32_t i = 0; i < b->n_out; ++i) {
        if (b->out[(b->out_at + i) % PAL_BRIDGE_OUT_BYTES] == CLOSE) return i + 2;
    }
    return n_pending;
}

static uint64_t sent_clock(const pal_usb_device* d) {
    if (!d->bridge.busy) return UINT64_MAX;
    const uint64_t n_more = n_until_answer(d) - 1;
    return pal_bridge_sent_clock(&d->bridge) + n_more * byte_clocks(d, d->bridge.clocks_per_bit);
}

uint64_t pal_usb_device_next_us(const pal_usb_device* device) {
    const uint64_t now = device->now_us;
    uint64_t at = device->fault_us;
    if (device->plugged && !device->no_tokens) {
        if (!pal_usb_usable(device, PAL_USB_FAULT_EP_IN) || device->n_again > 0) return now;
        const uint64_t held = device->split_us > device->hold_us ? device->split_us : device->hold_us;
        if (held > now) {
            at = pal_usb_earlier(at, held);
        } else if (device->split_us > 0 || pal_bridge_in_ready(&device->bridge, now)) {
            return now;
        } else {
            const uint64_t line = pal_usb_earlier(said_clock(device), sent_clock(device));
            at = pal_usb_earlier(at, pal_bridge_timer_us(&device->bridge));
            if (line != UINT64_MAX) at = pal_usb_earlier(at, us_of(line));
        }
    }
    return at > now ? at : now + 1;
}
