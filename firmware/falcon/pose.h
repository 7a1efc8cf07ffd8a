/// Position and velocity from encoder readings.
#pragma once
#include <stdbool.h>
#include <stdint.h>

#include "firmware/core/delta.h"
#include "firmware/falcon/force.h"
#ifdef __cplusplus
extern "C" {
#endif

enum {
    PAL_POSE_WORKSPACE = PAL_FORCE_WORKSPACE,  ///< no position belongs to these readings
    PAL_POSE_JUMP = 1 << 7                     ///< a reading further from the last than an arm can move
};

/// Zero-initialise: nothing known.
typedef struct pal_pose {
    float position_m[3];
    float velocity_m_per_s[3];
    int16_t counts[3];
    bool has_position, has_counts;
} pal_pose;

typedef struct pal_pose_config {
    float start_m[3];                ///< where the search for the first position starts
    int16_t jump_max_counts_per_ms;  ///< of one reading from the last, in a millisecond
    float velocity_cutoff_hz;        ///< f of the filter below
} pal_pose_config;

/// One sample, `dt_us` after the last. Position: forward kinematics, two Newton steps from the last position,
/// up to twelve from start_m when there is none or it is too far away. Velocity: v += a (dx / dt - v), a = dt
/// / (dt + 1 / (2 pi f)), from v = 0; a first-order low-pass whose lag is 1 / (2 pi f), 3.2 ms at 50 Hz, and
/// which lets through the share (a / (2 - a))^1/2 of the noise that one count of 46 um makes in 1 ms. Returns
/// PAL_POSE_*; with _WORKSPACE there is no position, with _JUMP the velocity starts anew.
uint32_t pal_pose_step(const pal_pose_config* config, const pal_delta* delta, pal_pose* pose,
                       const int16_t counts[3], uint32_t dt_us);

#ifdef __cplusplus
}
#endif
