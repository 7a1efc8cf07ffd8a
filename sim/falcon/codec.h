/// The device's side of the 16-byte packets (docs/PROTOCOL.md 4).
#pragma once
#include <stdbool.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

enum { PAL_FALCON_PACKET_BYTES = 16 };

typedef struct pal_falcon_request {
    int16_t motor_counts[3];
    uint8_t flags;  ///< 1 homing, 2 green, 4 blue, 8 red
    uint8_t spare;  ///< byte 14, minus 'A'
} pal_falcon_request;

/// Whether `byte` may stand at place `n` of a request.
bool pal_falcon_request_byte_ok(uint8_t byte, unsigned n);
/// `packet`: 16 bytes that all passed pal_falcon_request_byte_ok.
pal_falcon_request pal_falcon_request_decode(const uint8_t packet[16]);
/// `flags`: bits 0-3 grip buttons, 4-6 homed.
void pal_falcon_reply_encode(const int16_t encoder_counts[3], uint8_t flags, uint8_t packet[16]);

#ifdef __cplusplus
}
#endif
