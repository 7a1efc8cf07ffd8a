/// The 16-byte packets of the Falcon's run-time exchange, both ways. Bytes in, values out: no I/O. Layout and
/// worked examples: docs/PROTOCOL.md 4.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

enum { PAL_WIRE_BYTES = 16 };

/// Low nibble of a request's byte 13.
enum { PAL_WIRE_HOMING = 1, PAL_WIRE_GREEN = 2, PAL_WIRE_BLUE = 4, PAL_WIRE_RED = 8, PAL_WIRE_LEDS = 14 };

typedef struct pal_wire_request {
    int16_t motor_counts[3];
    uint8_t flags;  ///< PAL_WIRE_*
} pal_wire_request;

typedef struct pal_wire_reply {
    int16_t encoder_counts[3];
    uint8_t buttons;  ///< bits 0-3: plus (right), lightning (forward), circle (centre), minus (left)
    uint8_t homed;    ///< bits 0-2: arm 1 (top), 2 (right), 3 (left); valid while homing is asked for
} pal_wire_reply;

void pal_packet_encode(const pal_wire_request* request, uint8_t packet[PAL_WIRE_BYTES]);
/// What a device would have sent; bits beyond the four buttons and three arms are left out.
void pal_packet_encode_reply(const pal_wire_reply* reply, uint8_t packet[PAL_WIRE_BYTES]);
/// False, `reply` untouched, when the bytes are no reply.
bool pal_packet_decode(const uint8_t packet[PAL_WIRE_BYTES], pal_wire_reply* reply);

/// Cuts a byte stream into packets. Zero-initialise. '<' never occurs within a packet, so each one starts
/// afresh.
typedef struct pal_wire_reader {
    uint8_t bytes[PAL_WIRE_BYTES];
    uint8_t n_bytes;
    uint32_t n_skipped_bytes;  ///< that belonged to no packet
} pal_wire_reader;

/// Takes one byte. True when it completed a packet, which is then in reader->bytes until the next call.
bool pal_wire_feed(pal_wire_reader* reader, uint8_t byte);

#ifdef __cplusplus
}
#endif
