/// Position and velocity from encoder counts.
#pragma once
#include "firmware/core/step.h"
#ifdef __cplusplus
extern "C" {
#endif

/// Moves position, velocity and the work on the hand on to a fresh sample, `n_ticks` after the last one.
/// Returns 0, PAL_FAULT_NOT_FINITE or PAL_FAULT_WORKSPACE; then there is no position.
uint32_t pal_track(const pal_loop_config* config, pal_loop* loop, const int16_t counts[3], uint32_t n_ticks);

#ifdef __cplusplus
}
#endif
