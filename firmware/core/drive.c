#include "firmware/core/drive.h"

#include <math.h>

static const float WORD_MAX = 32767.0F;

static float magnitude(float x) {
    return x < 0.0F ? -x : x;
}

static void scale(float v[3], float by) {
    for (int c = 0; c < 3; ++c) v[c] *= by;
}

static uint32_t none(float force_n[3], int16_t motor_counts[3], uint32_t fault) {
    for (int c = 0; c < 3; ++c) {
        force_n[c] = 0.0F;
        motor_counts[c] = 0;
    }
    return fault;
}

static int16_t nearest(float x) {
    return (int16_t)(x < 0.0F ? x - 0.5F : x + 0.5F);  // |x| <= WORD_MAX was checked
}

uint32_t pal_drive_force(const pal_loop_config* config, const pal_loop* loop, float force_n[3],
                         int16_t motor_counts[3]) {
    uint32_t faults = 0;
    if (force_n[0] == 0.0F && force_n[1] == 0.0F && force_n[2] == 0.0F) return none(force_n, motor_counts, 0);
    const float length_n = sqrtf(force_n[0] * force_n[0] + force_n[1] * force_n[1] + force_n[2] * force_n[2]);
    if (!(length_n <= 1.0e9F && config->force_max_n >= 0.0F)) {
        return none(force_n, motor_counts, PAL_FAULT_NOT_FINITE);
    }
    if (length_n > config->force_max_n) {
        scale(force_n, config->force_max_n / length_n);
        faults |= PAL_FAULT_FORCE_CLAMP;
    }
    float words[3];
    if (!pal_delta_torque(config->delta, loop->position_m, force_n, words)) {
        return none(force_n, motor_counts, faults | PAL_FAULT_WORKSPACE);
    }
    scale(words, -config->delta->units_per_n_m);
    float largest = magnitude(words[0]);
    for (int i = 1; i < 3; ++i) largest = magnitude(words[i]) > largest ? magnitude(words[i]) : largest;
    const float limit = (float)config->delta->motor_max;
    if (largest > limit) {
        scale(words, limit / largest);
        scale(force_n, limit / largest);
        faults |= PAL_FAULT_MOTOR_CLAMP;
    }
    for (int i = 0; i < 3; ++i) {
        if (!(magnitude(words[i]) <= WORD_MAX))
            return none(force_n, motor_counts, faults | PAL_FAULT_NOT_FINITE);
    }
    for (int i = 0; i < 3; ++i) motor_counts[i] = nearest(words[i]);
    return faults;
}
