/// From a force to motor words.
#pragma once
#include "firmware/core/step.h"
#ifdef __cplusplus
extern "C" {
#endif

/// Cuts |force_n| to config->force_max_n, turns it into motor words at loop->position_m, scales all three
/// together when one would pass the limit. `force_n` becomes what the words stand for before rounding.
/// Returns PAL_FAULT_FORCE_CLAMP, _MOTOR_CLAMP; _NOT_FINITE or _WORKSPACE with zero words and force.
uint32_t pal_drive_force(const pal_loop_config* config, const pal_loop* loop, float force_n[3],
                         int16_t motor_counts[3]);

#ifdef __cplusplus
}
#endif
