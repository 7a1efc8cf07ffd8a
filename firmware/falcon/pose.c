#include "firmware/falcon/pose.h"

enum { WARM_STEPS = 2, COLD_STEPS = 12, US_PER_MS = 1000, GAP_MAX_MS = 100 };
static const float US_PER_S = 1.0e6F;
static const float TWO_PI = 6.28318531F;

static bool jumped(const pal_pose_config* config, const pal_pose* pose, const int16_t counts[3],
                   uint32_t dt_us) {
    if (!pose->has_counts) return false;
    uint32_t gap_ms = 1U + dt_us / US_PER_MS;
    if (gap_ms > GAP_MAX_MS) gap_ms = GAP_MAX_MS;
    const int32_t allowed = (int32_t)gap_ms * config->jump_max_counts_per_ms;
    for (int i = 0; i < 3; ++i) {
        const int32_t moved = (int32_t)counts[i] - pose->counts[i];
        if (moved > allowed || moved < -allowed) return true;
    }
    return false;
}

uint32_t pal_pose_step(const pal_pose_config* config, const pal_delta* delta, pal_pose* pose,
                       const int16_t counts[3], uint32_t dt_us) {
    uint32_t faults = jumped(config, pose, counts, dt_us) ? (uint32_t)PAL_POSE_JUMP : 0U;
    float theta_rad[3];
    for (int i = 0; i < 3; ++i) {
        theta_rad[i] = pal_delta_theta_rad(delta, counts[i]);
        pose->counts[i] = counts[i];
    }
    pose->has_counts = true;
    float at_m[3];
    const bool warm = faults == 0 && pose->has_position &&
                      pal_delta_forward(delta, theta_rad, pose->position_m, WARM_STEPS, at_m);
    if (!warm && !pal_delta_forward(delta, theta_rad, config->start_m, COLD_STEPS, at_m)) {
        faults |= (uint32_t)PAL_POSE_WORKSPACE;
    }
    const bool found = (faults & (uint32_t)PAL_POSE_WORKSPACE) == 0;
    const float dt_s = (float)dt_us / US_PER_S;
    const float share = dt_s / (dt_s + 1.0F / (TWO_PI * config->velocity_cutoff_hz));
    for (int c = 0; c < 3; ++c) {
        float velocity = 0.0F;
        if (warm) {
            velocity = pose->velocity_m_per_s[c];
            if (dt_us > 0) velocity += share * ((at_m[c] - pose->position_m[c]) / dt_s - velocity);
        }
        pose->velocity_m_per_s[c] = velocity;
        if (found) pose->position_m[c] = at_m[c];
    }
    pose->has_position = found;
    return faults;
}
