#include "firmware/falcon/homing.h"

bool pal_homing_step(pal_homing* homing, uint8_t flags, bool asked) {
    const bool all = (flags & PAL_HOMED_ALL) == PAL_HOMED_ALL;
    if (!asked || all == homing->homed) {
        homing->n_same = 0;
        return false;
    }
    homing->n_same = (uint8_t)(homing->n_same + 1U);
    if (homing->n_same < PAL_HOMED_REPLIES) return false;
    homing->n_same = 0;
    homing->homed = all;
    return true;
}

void pal_grip_step(pal_grip* grip, uint8_t raw, uint32_t dt_us, uint32_t hold_us) {
    const uint32_t before = grip->differing;
    const uint32_t differing = (raw ^ grip->buttons) & (uint32_t)((1U << PAL_GRIP_BUTTONS) - 1U);
    uint32_t turned = 0;
    for (uint32_t b = 0; b < PAL_GRIP_BUTTONS; ++b) {
        const uint32_t mask = 1U << b;
        if ((differing & mask) == 0) continue;
        const uint32_t lasted_us = (before & mask) != 0 ? grip->changed_us[b] : 0U;
        const uint32_t more_us = (before & mask) != 0 ? dt_us : 0U;
        if (more_us >= hold_us - lasted_us)
            turned |= mask;  // lasted_us stays at or below hold_us
        else
            grip->changed_us[b] = lasted_us + more_us;
    }
    grip->buttons = (uint8_t)(grip->buttons ^ turned);
    grip->differing = (uint8_t)(differing & ~turned);
}
