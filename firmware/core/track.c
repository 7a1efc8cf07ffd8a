#include "firmware/core/track.h"

static const float TICKS_PER_S = 1000.0F;
static const float VELOCITY_SHARE = 0.269597F;  // 1 - exp(-2 pi 50 Hz 1 ms): first-order low-pass
enum { WARM_STEPS = 2, COLD_STEPS = 12 };

static uint32_t lose(pal_loop* loop, uint32_t fault) {
    loop->has_position = false;
    for (int c = 0; c < 3; ++c) loop->velocity_m_per_s[c] = 0.0F;
    return fault;
}

uint32_t pal_track(const pal_loop_config* config, pal_loop* loop, const int16_t counts[3], uint32_t n_ticks) {
    float theta_rad[3];
    for (int i = 0; i < 3; ++i) {
        theta_rad[i] = pal_delta_theta_rad(config->delta, counts[i]);
        if (!(theta_rad[i] >= -1.0e3F && theta_rad[i] <= 1.0e3F)) return lose(loop, PAL_FAULT_NOT_FINITE);
    }
    float at_m[3];
    const bool warm =
        loop->has_position && pal_delta_forward(config->delta, theta_rad, loop->position_m, WARM_STEPS, at_m);
    if (!warm && !pal_delta_forward(config->delta, theta_rad, config->centre_m, COLD_STEPS, at_m)) {
        return lose(loop, PAL_FAULT_WORKSPACE);
    }
    const float per_s = TICKS_PER_S / (float)n_ticks;
    for (int c = 0; c < 3; ++c) {
        const float moved_m = loop->has_position ? at_m[c] - loop->position_m[c] : 0.0F;
        const float velocity = loop->velocity_m_per_s[c];
        loop->velocity_m_per_s[c] = warm ? velocity + VELOCITY_SHARE * (moved_m * per_s - velocity) : 0.0F;
        loop->hand_work_j += loop->commanded_n[c] * moved_m;
        loop->position_m[c] = at_m[c];
    }
    loop->has_position = true;
    loop->tracked = true;
    return 0;
}
