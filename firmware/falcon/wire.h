/// The 16-byte packets of the Falcon's run-time exchange, both ways. Bytes in, values out: no I/O. Layout and
/// worked examples: docs/PROTOCOL.md 4.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "firmware/core/step.h"
#ifdef __cplusplus
extern "C" {
#endif

enum { PAL_WIRE_BYTES = 16 };

/// Request to the device: motor words, homing bit, LEDs.
void pal_wire_encode(const pal_drive* drive, uint8_t packet[PAL_WIRE_BYTES]);
/// Reply of the device: sets encoder_counts, buttons, homed and fresh = 1, leaves the rest. False, `sense`
/// untouched, when the bytes are no reply.
bool pal_wire_decode(const uint8_t packet[PAL_WIRE_BYTES], pal_sense* sense);

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
