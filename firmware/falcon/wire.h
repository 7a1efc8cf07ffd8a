/// The run-time packets (packet.h) in the words of the loop's tick: pal_drive out, pal_sense in.
#pragma once
#include "firmware/core/step.h"
#include "firmware/falcon/packet.h"
#ifdef __cplusplus
extern "C" {
#endif

/// Request to the device: motor words, homing bit, LEDs.
void pal_wire_encode(const pal_drive* drive, uint8_t packet[PAL_WIRE_BYTES]);
/// Reply of the device: sets encoder_counts, buttons, homed and fresh = 1, leaves the rest. False, `sense`
/// untouched, when the bytes are no reply.
bool pal_wire_decode(const uint8_t packet[PAL_WIRE_BYTES], pal_sense* sense);

#ifdef __cplusplus
}
#endif
