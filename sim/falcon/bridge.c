#include "sim/falcon/bridge.h"

#include <string.h>

enum {
    REQUEST_OUT = 0x40,
    REQUEST_IN = 0xC0,
    RESET = 0x00,
    MODEM_CTRL = 0x01,
    SET_FLOW = 0x02,
    SET_BAUD = 0x03,
    SET_DATA = 0x04,
    GET_MODEM = 0x05,
    SET_EVENT = 0x06,
    SET_ERROR = 0x07,
    SET_LATENCY = 0x09,
    GET_LATENCY = 0x0A,
    READ_EEPROM = 0x90,
    WRITE_EEPROM = 0x91,

    RESET_ALL = 0,
    PURGE_OUT = 1,
    PURGE_IN = 2,
    DTR_BIT = 1,
    RTS_BIT = 2,
    FLOW_CTS = 1,
    FLOW_DSR = 2,
    FLOW_XON = 4,
    FLOW_ALL = 7,
    ON_BIT = 0x100,

    MODEM_FIXED = 0x01,
    CTS_IN = 0x10,
    DSR_IN = 0x20,
    MODEM_MASK = 0xF0,
    OVERRUN = 0x02,
    FRAMING = 0x08,
    THR_EMPTY = 0x20,
    TX_EMPTY = 0x40,

    FORMAT_8N1 = 0x0008,
    FORMAT_BREAK = 0x4000,
    PARITY_MASK = 0x0700,
    STOP_SHIFT = 11,
    EVENT_AT_RESET = 0x0D
};

void pal_bridge_reset(pal_bridge* bridge, uint64_t now_us) {
    pal_bridge fresh;
    memset(&fresh, 0, sizeof fresh);
    memcpy(fresh.eeprom, bridge->eeprom, sizeof fresh.eeprom);
    fresh.modem_lines = bridge->modem_lines;
    fresh.instant = bridge->instant;
    fresh.clocks_per_bit = PAL_UART_PIC_CLOCKS_PER_BIT;  // 9600 baud until somebody asks for another
    fresh.data_format = FORMAT_8N1;
    fresh.latency_ms = PAL_BRIDGE_LATENCY_MS;
    fresh.event = EVENT_AT_RESET;
    fresh.timer_us = now_us;
    *bridge = fresh;
}

uint32_t pal_bridge_divisor_clocks(uint16_t value, uint16_t index) {
    static const uint8_t EIGHTHS[8] = {0, 4, 2, 1, 3, 5, 6, 7};  // by the 3-bit code
    const uint32_t whole = value & 0x3FFFU;
    const uint32_t code = (uint32_t)value >> 14 | (index & 1U) << 2;
    if (whole == 0 && code == 0) return 8;   // 3 Mbaud
    if (whole == 1 && code == 0) return 12;  // 2 Mbaud
    return whole < 2 ? 0 : 8 * whole + EIGHTHS[code];
}

/// Whether the flow control lets the next byte go.
static bool may_send(const pal_bridge* b) {
    if (b->data_format & FORMAT_BREAK) return false;
    if ((b->flow & FLOW_CTS) && !(b->modem_lines & CTS_IN)) return false;
    if ((b->flow & FLOW_DSR) && !(b->modem_lines & DSR_IN)) return false;
    return !((b->flow & FLOW_XON) && b->xoffed);
}

static uint32_t bits_per_byte(uint16_t format) {
    const uint32_t parity = (format & PARITY_MASK) ? 1 : 0;
    const uint32_t stops = (format >> STOP_SHIFT & 3U) ? 2 : 1;
    return 1 + (format & 0xFFU) + parity + stops;
}

/// Puts the next byte on the line when nothing is in its way.
static void begin_byte(pal_bridge* b, uint64_t now_clock) {
    if (b->busy || b->n_out == 0 || !may_send(b)) return;
    const uint64_t from = now_clock > b->not_before_clock ? now_clock : b->not_before_clock;
    b->sending.byte = b->out[b->out_at];
    b->sending.clocks_per_bit = b->clocks_per_bit;
    b->sending.frame_ok = (b->data_format & ~FORMAT_BREAK) == FORMAT_8N1;
    b->out_at = (b->out_at + 1) % PAL_BRIDGE_OUT_BYTES;
    --b->n_out;
    b->from_clock = from;
    b->sent_clock = from + (b->instant ? 0 : (uint64_t)b->clocks_per_bit * bits_per_byte(b->data_format));
    b->busy = true;
}

static void purge_in(pal_bridge* b) {
    b->n_in = b->in_at = b->n_flush = 0;
}

static void purge_out(pal_bridge* b) {
    b->n_out = b->out_at = 0;  // the byte that is on the line goes on
}

static bool reset_request(pal_bridge* b, uint16_t value) {
    if (value > PURGE_IN) return false;
    if (value != PURGE_IN) purge_out(b);
    if (value != PURGE_OUT) purge_in(b);
    if (value != RESET_ALL) return true;
    b->flow = 0;
    b->xoffed = false;
    b->event = EVENT_AT_RESET;
    b->event_on = b->dtr = b->rts = false;
    return true;
}

static void status_bytes(const pal_bridge* b, uint8_t status[2]) {
    status[0] = (uint8_t)(MODEM_FIXED | (b->modem_lines & MODEM_MASK));
    status[1] = b->line_errors;
    if (b->n_out == 0) status[1] |= THR_EMPTY;
    if (b->n_out == 0 && !b->busy) status[1] |= TX_EMPTY;
}

static bool set_baud(pal_bridge* b, uint16_t value, uint16_t index) {
    const uint32_t clocks = pal_bridge_divisor_clocks(value, index);
    if (clocks == 0) return false;
    b->clocks_per_bit = clocks;
    return true;
}

static bool set_format(pal_bridge* b, uint16_t value) {
    const uint16_t n_bits = value & 0xFFU;
    if (n_bits != 7 && n_bits != 8) return false;
    b->data_format = value;
    return true;
}

static bool set_flow(pal_bridge* b, uint16_t value, uint16_t index) {
    const uint8_t flow = (uint8_t)(index >> 8);
    if (flow & ~FLOW_ALL) return false;
    b->flow = flow;
    b->xon = (uint8_t)value;
    b->xoff = (uint8_t)(value >> 8);
    b->xoffed = false;
    return true;
}

static bool set_latency(pal_bridge* b, uint16_t value, uint64_t now_us) {
    if (value < 1 || value > 255) return false;
    b->latency_ms = (uint8_t)value;
    b->timer_us = now_us;
    return true;
}

static bool write_eeprom(pal_bridge* b, uint16_t value, uint16_t index) {
    if (index >= PAL_BRIDGE_EEPROM_WORDS) return false;
    b->eeprom[index] = value;
    return true;
}

static bool set_modem(pal_bridge* b, uint16_t value) {
    if (value >> 8 & DTR_BIT) b->dtr = (value & DTR_BIT) != 0;
    if (value >> 8 & RTS_BIT) b->rts = (value & RTS_BIT) != 0;
    return true;
}

static bool request_out(pal_bridge* b, uint64_t now_us, const uint8_t setup[8]) {
    const uint16_t value = (uint16_t)(setup[2] | setup[3] << 8);
    const uint16_t index = (uint16_t)(setup[4] | setup[5] << 8);
    switch (setup[1]) {
        case RESET:
            return reset_request(b, value);
        case MODEM_CTRL:
            return set_modem(b, value);
        case SET_FLOW:
            return set_flow(b, value, index);
        case SET_BAUD:
            return set_baud(b, value, index);
        case SET_DATA:
            return set_format(b, value);
        case SET_EVENT:
            b->event = (uint8_t)value;
            b->event_on = (value & ON_BIT) != 0;
            return true;
        case SET_ERROR:
            return true;  // not modelled: no driver turns it on, and a framing error is told by the status
        case SET_LATENCY:
            return set_latency(b, value, now_us);
        case WRITE_EEPROM:
            return write_eeprom(b, value, index);
        default:
            return false;
    }
}

static int request_in(const pal_bridge* b, const uint8_t setup[8], uint8_t answer[2]) {
    const uint16_t index = (uint16_t)(setup[4] | setup[5] << 8);
    switch (setup[1]) {
        case GET_MODEM:
            status_bytes(b, answer);
            return 2;
        case GET_LATENCY:
            answer[0] = b->latency_ms;
            return 1;
        case READ_EEPROM: {
            const uint16_t word = index < PAL_BRIDGE_EEPROM_WORDS ? b->eeprom[index] : 0xFFFF;
            answer[0] = (uint8_t)word;
            answer[1] = (uint8_t)(word >> 8);
            return 2;
        }
        default:
            return PAL_BRIDGE_STALL;
    }
}

int pal_bridge_request(pal_bridge* bridge, uint64_t now_us, const uint8_t setup[8], uint8_t* data,
                       size_t n_bytes) {
    if (setup[0] == REQUEST_OUT) {
        if (!request_out(bridge, now_us, setup)) return PAL_BRIDGE_STALL;
        begin_byte(bridge, pal_uart_clock(now_us));
        return 0;
    }
    if (setup[0] != REQUEST_IN) return PAL_BRIDGE_STALL;
    uint8_t answer[2];
    int n = request_in(bridge, setup, answer);
    if (n > (int)n_bytes) n = (int)n_bytes;
    if (n > 0) memcpy(data, answer, (size_t)n);
    return n;
}

int pal_bridge_out(pal_bridge* bridge, const uint8_t* bytes, size_t n_bytes, uint64_t now_clock) {
    if (n_bytes > PAL_BRIDGE_OUT_BYTES - bridge->n_out) return 0;
    for (size_t i = 0; i < n_bytes; ++i) {
        bridge->out[(bridge->out_at + bridge->n_out) % PAL_BRIDGE_OUT_BYTES] = bytes[i];
        ++bridge->n_out;
    }
    begin_byte(bridge, now_clock);
    return (int)n_bytes;
}

void pal_bridge_release(pal_bridge* bridge, uint64_t now_clock) {
    bridge->not_before_clock = 0;
    if (!bridge->busy || bridge->from_clock <= now_clock) return;
    bridge->sent_clock -= bridge->from_clock - now_clock;
    bridge->from_clock = now_clock;
}

uint64_t pal_bridge_sent_clock(const pal_bridge* bridge) {
    return bridge->busy ? bridge->sent_clock : UINT64_MAX;
}

pal_line_byte pal_bridge_sent(pal_bridge* bridge) {
    const pal_line_byte sent = bridge->sending;
    bridge->busy = false;
    begin_byte(bridge, bridge->sent_clock);
    return sent;
}

void pal_bridge_receive(pal_bridge* bridge, uint8_t byte, bool frame_ok, uint64_t now_clock) {
    if (!frame_ok) {
        bridge->line_errors |= FRAMING;
        bridge->status_news = true;
    }
    if ((bridge->flow & FLOW_XON) && (byte == bridge->xon || byte == bridge->xoff)) {
        bridge->xoffed = byte == bridge->xoff;
        begin_byte(bridge, now_clock);
        return;
    }
    if (bridge->n_in == PAL_BRIDGE_IN_BYTES) {
        bridge->line_errors |= OVERRUN;
        bridge->status_news = true;
        return;
    }
    bridge->in[(bridge->in_at + bridge->n_in) % PAL_BRIDGE_IN_BYTES] = byte;
    ++bridge->n_in;
    // The chip does not see an event character that comes first in its buffer.
    if (bridge->event_on && byte == bridge->event && bridge->n_in > 1) bridge->n_flush = bridge->n_in;
}

uint64_t pal_bridge_timer_us(const pal_bridge* bridge) {
    return bridge->timer_us + 1000U * (uint64_t)bridge->latency_ms;
}

bool pal_bridge_in_ready(const pal_bridge* bridge, uint64_t now_us) {
    return bridge->status_news || bridge->n_flush > 0 || bridge->n_in >= PAL_BRIDGE_PAYLOAD_BYTES ||
           (bridge->instant && bridge->n_in > 0) || now_us >= pal_bridge_timer_us(bridge);
}

int pal_bridge_in(pal_bridge* bridge, uint64_t now_us, uint32_t n_payload_max,
                  uint8_t packet[PAL_BRIDGE_PACKET_BYTES]) {
    uint32_t n = n_payload_max < PAL_BRIDGE_PAYLOAD_BYTES ? n_payload_max : PAL_BRIDGE_PAYLOAD_BYTES;
    if (n > bridge->n_in) n = bridge->n_in;
    status_bytes(bridge, packet);
    for (uint32_t i = 0; i < n; ++i) packet[2 + i] = bridge->in[(bridge->in_at + i) % PAL_BRIDGE_IN_BYTES];
    bridge->in_at = (bridge->in_at + n) % PAL_BRIDGE_IN_BYTES;
    bridge->n_in -= n;
    bridge->n_flush -= n < bridge->n_flush ? n : bridge->n_flush;
    bridge->line_errors = 0;
    bridge->status_news = false;
    bridge->timer_us = now_us;
    return (int)(2 + n);
}
