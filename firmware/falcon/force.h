/// From a force to motor words that are safe to send: vector clamp, start ramp, saturation and a thermal
/// limit, the last two by one factor common to the three motors so that the direction stays.
#pragma once
#include <stdbool.h>
#include <stdint.h>

#include "firmware/core/delta.h"
#ifdef __cplusplus
extern "C" {
#endif

/// What was done to a force. PAL_FORCE_NOT_FINITE and _WORKSPACE mean zero words.
enum {
    PAL_FORCE_NOT_FINITE = 1 << 0,  ///< NaN or infinite in force or limit
    PAL_FORCE_WORKSPACE = 1 << 1,   ///< singular or unreachable position
    PAL_FORCE_CLAMPED = 1 << 2,     ///< |force| cut to the limit
    PAL_FORCE_SATURATED = 1 << 3,   ///< a motor word would have passed the motor's maximum
    PAL_FORCE_WARM = 1 << 4         ///< cut by the thermal limit
};

typedef struct pal_force_config {
    float force_max_n;     ///< on every |force|, in (0, 8.9]: the device's rating is 8.9 N
    uint32_t ramp_us;      ///< after every start from zero the force grows linearly over this time; 0: none
    float rms_max_counts;  ///< motor word that may be held for ever
    float rms_time_s;      ///< time constant of the heat in a motor
    float rms_margin;      ///< G: a motor with mean square q may have word^2 <= L^2 + G (L^2 - q)
} pal_force_config;

/// 8 N, 0.5 s. Thermal: 2000 units for ever, 10 s, G = 4, so a cold motor is not limited at all: an
/// assumption, no source states what the motors bear (the supply gives 30 V, 1 A for all three).
pal_force_config pal_force_config_default(void);

/// Zero-initialise: cold motors, at the foot of the ramp.
typedef struct pal_force {
    float mean_square[3];  ///< q: first-order mean of the squared words
    int16_t words[3];      ///< as sent last, taken as held since
    uint32_t ramped_us;    ///< time on the ramp so far
    bool at_foot;          ///< restarted: the ramp begins at the next elapse
} pal_force;

/// Back to the foot of the ramp. Motors stay as warm as they are.
void pal_force_restart(pal_force* state);
/// Heat for `dt_us` with the words sent last, and time on the ramp. Call once before each pal_force_words,
/// pal_force_counts or pal_force_zero that is sent.
void pal_force_elapse(const pal_force_config* config, pal_force* state, uint32_t dt_us);
/// Words for `force_n` (N, on the hand, device frame) at `at_m`; `limit_n` is clamped to force_max_n and NaN
/// there is a fault. `applied_n`: what the words stand for before rounding. Returns PAL_FORCE_*.
uint32_t pal_force_words(const pal_force_config* config, const pal_delta* delta, pal_force* state,
                         const float at_m[3], const float force_n[3], float limit_n, float applied_n[3]);
/// Words given instead of a force: ramp, saturation and thermal limit alone.
uint32_t pal_force_counts(const pal_force_config* config, const pal_delta* delta, pal_force* state,
                          const int16_t motor_counts[3]);
/// Zero words.
void pal_force_zero(pal_force* state);

#ifdef __cplusplus
}
#endif
