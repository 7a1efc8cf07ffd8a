#include "firmware/falcon/force.h"

#include <math.h>

static const float FORCE_SANE_N = 1.0e9F;  // its square is finite in float
static const float US_PER_S = 1.0e6F;
static const float WORD_MAX = 32767.0F;

pal_force_config pal_force_config_default(void) {
    pal_force_config config = {
        .force_max_n = 8.0F,
        .ramp_us = 500000,
        .rms_max_counts = 2000.0F,
        .rms_time_s = 10.0F,
        .rms_margin = 4.0F,
    };
    return config;
}

void pal_force_restart(pal_force* state) {
    state->ramped_us = 0;
    state->at_foot = true;
}

void pal_force_zero(pal_force* state) {
    for (int i = 0; i < 3; ++i) state->words[i] = 0;
}

void pal_force_elapse(const pal_force_config* config, pal_force* state, uint32_t dt_us) {
    const uint32_t left_us = config->ramp_us > state->ramped_us ? config->ramp_us - state->ramped_us : 0U;
    if (!state->at_foot) state->ramped_us += dt_us < left_us ? dt_us : left_us;
    state->at_foot = false;
    const float dt_s = (float)dt_us / US_PER_S;
    const float share = dt_s / (config->rms_time_s + dt_s);  // implicit Euler: stable for any dt
    for (int i = 0; i < 3; ++i) {
        const float word = (float)state->words[i];
        state->mean_square[i] += share * (word * word - state->mean_square[i]);
    }
}

static float ramp(const pal_force_config* config, const pal_force* state) {
    if (state->ramped_us >= config->ramp_us) return 1.0F;
    return (float)state->ramped_us / (float)config->ramp_us;
}

// Largest word that motor i may have now.
static float warm_max(const pal_force_config* config, const pal_force* state, int i) {
    const float ever = config->rms_max_counts * config->rms_max_counts;
    const float square = ever + config->rms_margin * (ever - state->mean_square[i]);
    return square > 0.0F ? sqrtf(square) : 0.0F;
}

// Scales `words` by the one factor that both limits need, rounds, keeps. The factor comes back.
static float settle(const pal_force_config* config, const pal_delta* delta, pal_force* state,
                    const float words[3], uint32_t* faults) {
    float factor = 1.0F;
    for (int i = 0; i < 3; ++i) {
        const float size = fabsf(words[i]);
        const float motor = (float)delta->motor_max;
        const float warm = warm_max(config, state, i);
        if (size * factor > motor) {
            factor = motor / size;
            *faults |= PAL_FORCE_SATURATED;
        }
        if (size * factor > warm) {
            factor = warm / size;
            *faults |= PAL_FORCE_WARM;
        }
    }
    for (int i = 0; i < 3; ++i) {
        const float word = words[i] * factor;
        const bool fits = fabsf(word) <= WORD_MAX;
        state->words[i] = fits ? (int16_t)(word < 0.0F ? word - 0.5F : word + 0.5F) : (int16_t)0;
    }
    return factor;
}

// The length of a force; NaN unless everything is finite.
static float length_of(const float force_n[3]) {
    float sum = 0.0F;
    for (int c = 0; c < 3; ++c) {
        if (!(fabsf(force_n[c]) <= FORCE_SANE_N)) return NAN;
        sum += force_n[c] * force_n[c];
    }
    return sqrtf(sum);
}

uint32_t pal_force_words(const pal_force_config* config, const pal_delta* delta, pal_force* state,
                         const float at_m[3], const float force_n[3], float limit_n, float applied_n[3]) {
    pal_force_zero(state);
    for (int c = 0; c < 3; ++c) applied_n[c] = 0.0F;
    const float length_n = length_of(force_n);
    if (!(length_n >= 0.0F) || !(fabsf(limit_n) <= FORCE_SANE_N)) return PAL_FORCE_NOT_FINITE;
    uint32_t faults = 0;
    float limit = limit_n > 0.0F ? limit_n : 0.0F;
    if (limit > config->force_max_n) limit = config->force_max_n;
    float part = ramp(config, state);
    if (length_n > limit) {
        part *= limit / length_n;
        faults |= PAL_FORCE_CLAMPED;
    }
    float words[3];
    float asked_n[3];
    for (int c = 0; c < 3; ++c) asked_n[c] = part * force_n[c];
    if (!pal_delta_torque(delta, at_m, asked_n, words)) return faults | PAL_FORCE_WORKSPACE;
    for (int i = 0; i < 3; ++i)
        words[i] *= -delta->units_per_n_m;  // positive words pull towards smaller theta
    const float factor = settle(config, delta, state, words, &faults);
    for (int c = 0; c < 3; ++c) applied_n[c] = factor * asked_n[c];
    return faults;
}

uint32_t pal_force_counts(const pal_force_config* config, const pal_delta* delta, pal_force* state,
                          const int16_t motor_counts[3]) {
    uint32_t faults = 0;
    float words[3];
    for (int i = 0; i < 3; ++i) words[i] = ramp(config, state) * (float)motor_counts[i];
    (void)settle(config, delta, state, words, &faults);
    return faults;
}
