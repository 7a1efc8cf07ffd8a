#include "firmware/falcon/wire.h"

void pal_wire_encode(const pal_drive* drive, uint8_t packet[PAL_WIRE_BYTES]) {
    pal_wire_request request;
    for (int i = 0; i < 3; ++i) request.motor_counts[i] = drive->motor_counts[i];
    const uint32_t homing = drive->homing != 0 ? PAL_WIRE_HOMING : 0U;
    request.flags = (uint8_t)(homing | (drive->leds & (uint32_t)PAL_WIRE_LEDS));
    pal_packet_encode(&request, packet);
}

bool pal_wire_decode(const uint8_t packet[PAL_WIRE_BYTES], pal_sense* sense) {
    pal_wire_reply reply;
    if (!pal_packet_decode(packet, &reply)) return false;
    for (int i = 0; i < 3; ++i) sense->encoder_counts[i] = reply.encoder_counts[i];
    sense->buttons = reply.buttons;
    sense->homed = reply.homed;
    sense->fresh = 1;
    return true;
}
