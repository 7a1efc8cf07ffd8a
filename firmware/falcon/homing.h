/// Homing and the grip's buttons: what the flags of a reply mean over time.
#pragma once
#include <stdbool.h>
#include <stdint.h>

#include "firmware/falcon/packet.h"
#ifdef __cplusplus
extern "C" {
#endif

enum { PAL_HOMED_ALL = 7, PAL_HOMED_REPLIES = 3, PAL_GRIP_BUTTONS = 4 };

/// The flags are valid only while homing is asked for. The latch: all three in three replies in a row; with
/// the bit kept, lost again after three replies without all three. Zero-initialise.
typedef struct pal_homing {
    bool homed;
    uint8_t n_same;  ///< replies in a row that say otherwise
} pal_homing;

/// `asked`: the homing bit was in the request. True when `homed` changed.
bool pal_homing_step(pal_homing* homing, uint8_t flags, bool asked);

/// Debounced buttons: a change counts once it has lasted `hold_us`. Zero-initialise.
typedef struct pal_grip {
    uint8_t buttons;
    uint8_t differing;                      ///< buttons whose last sample said otherwise
    uint32_t changed_us[PAL_GRIP_BUTTONS];  ///< for how long they have
} pal_grip;

/// `dt_us`: time since the sample before this one.
void pal_grip_step(pal_grip* grip, uint8_t raw, uint32_t dt_us, uint32_t hold_us);

#ifdef __cplusplus
}
#endif
