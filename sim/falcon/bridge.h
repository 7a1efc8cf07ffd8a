/// The FT232R between USB and the serial line: vendor requests, two FIFOs, and when an IN packet is ready.
/// Time in clocks of 24 MHz (PAL_UART_CLOCKS_PER_US).
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "sim/falcon/loader.h"
#ifdef __cplusplus
extern "C" {
#endif

enum {
    PAL_BRIDGE_PACKET_BYTES = 64,
    PAL_BRIDGE_PAYLOAD_BYTES = 62,  ///< after two status bytes
    PAL_BRIDGE_OUT_BYTES = 128,     ///< host to line
    PAL_BRIDGE_IN_BYTES = 256,      ///< line to host
    PAL_BRIDGE_EEPROM_WORDS = 64,
    PAL_BRIDGE_LATENCY_MS = 16  ///< at power-on
};

enum { PAL_BRIDGE_STALL = -1 };

typedef struct pal_bridge {
    uint8_t out[PAL_BRIDGE_OUT_BYTES], in[PAL_BRIDGE_IN_BYTES];
    uint32_t n_out, out_at, n_in, in_at;  ///< rings: how many, where the first is
    uint32_t n_flush;                     ///< so many of the IN bytes go at once
    uint64_t timer_us;                    ///< when the latency timer began
    uint64_t from_clock, sent_clock;      ///< when the byte that is on the line begins and ends
    uint64_t not_before_clock;            ///< no byte goes on the line before
    pal_line_byte sending;
    uint32_t clocks_per_bit;
    uint16_t data_format;  ///< as SET_DATA's wValue; 8 is 8N1
    uint8_t latency_ms;
    uint8_t flow;  ///< 0 none, 1 RTS/CTS, 2 DTR/DSR, 4 XON/XOFF
    uint8_t xon, xoff;
    uint8_t event;
    uint8_t modem_lines;  ///< bits 4-7: CTS DSR RI DCD, as they come in
    uint8_t line_errors;  ///< overrun, parity, framing, break since the last packet
    bool event_on, dtr, rts, busy, xoffed, status_news;
    bool instant;  ///< data are ready as soon as they are there
    uint16_t eeprom[PAL_BRIDGE_EEPROM_WORDS];
} pal_bridge;

/// As at power-on; the EEPROM and the modem lines stay as they are.
void pal_bridge_reset(pal_bridge* bridge, uint64_t now_us);
/// A vendor request. >= 0: bytes of data written to `data`; PAL_BRIDGE_STALL.
int pal_bridge_request(pal_bridge* bridge, uint64_t now_us, const uint8_t setup[8], uint8_t* data,
                       size_t n_bytes);
/// Bit time of a SET_BAUDRATE divisor, in clocks. 0: there is no such divisor.
uint32_t pal_bridge_divisor_clocks(uint16_t value, uint16_t index);

/// A bulk OUT packet: all of it or, when the FIFO has no room, 0.
int pal_bridge_out(pal_bridge* bridge, const uint8_t* bytes, size_t n_bytes, uint64_t now_clock);
/// No byte waits any longer for not_before_clock.
void pal_bridge_release(pal_bridge* bridge, uint64_t now_clock);
/// When the byte on the line ends; UINT64_MAX: none is on it.
uint64_t pal_bridge_sent_clock(const pal_bridge* bridge);
/// The byte that ends at that time; the next one begins.
pal_line_byte pal_bridge_sent(pal_bridge* bridge);
/// A byte has come from the line. `frame_ok` false: it came with a framing error.
void pal_bridge_receive(pal_bridge* bridge, uint8_t byte, bool frame_ok, uint64_t now_clock);

/// Whether an IN token gets a packet now.
bool pal_bridge_in_ready(const pal_bridge* bridge, uint64_t now_us);
/// The packet: two status bytes and at most `n_payload_max` of payload. Restarts the latency timer.
int pal_bridge_in(pal_bridge* bridge, uint64_t now_us, uint32_t n_payload_max,
                  uint8_t packet[PAL_BRIDGE_PACKET_BYTES]);
/// When the latency timer ends, in microseconds.
uint64_t pal_bridge_timer_us(const pal_bridge* bridge);

#ifdef __cplusplus
}
#endif
