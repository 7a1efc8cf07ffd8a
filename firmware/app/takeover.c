#include "firmware/app/takeover.h"

#include "firmware/falcon/wire.h"

pal_takeover_end pal_takeover_tick(pal_takeover* takeover, const pal_device* device) {
    const pal_drive zero = {.motor_counts = {0, 0, 0}};
    uint8_t packet[PAL_WIRE_BYTES];
    const pal_device_news reply = device->collect(device->context, packet);
    takeover->answered = takeover->answered || reply == PAL_DEVICE_FRESH;
    if (takeover->answered && takeover->n_sent >= PAL_SESSION_ZERO_TICKS) return PAL_TAKEOVER_DONE;
    if (reply == PAL_DEVICE_GONE) return PAL_TAKEOVER_HUNG_UP;
    if (takeover->n_ticks >= PAL_TAKEOVER_TICKS_MAX) return PAL_TAKEOVER_SILENT;
    takeover->n_ticks += 1U;
    pal_wire_encode(&zero, packet);
    const pal_device_news taken = device->send(device->context, packet);
    if (taken == PAL_DEVICE_GONE) return PAL_TAKEOVER_HUNG_UP;
    if (taken == PAL_DEVICE_FRESH) takeover->n_sent += 1U;
    return PAL_TAKEOVER_RUNS;
}
