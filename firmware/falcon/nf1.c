#include "firmware/core/delta.h"

#define DEGREE 0.0174532925F

// Sources of each number: docs/PROTOCOL.md 4. Units per N m are an inference from published packets, +-15 %.
const pal_delta PAL_DELTA_NF1 = {
    .arm_m = 0.060F,
    .forearm_m = 0.1025F,
    .offset_m = 0.0225F,
    .platform_u_m = 0.01443F,
    .platform_v_m = -0.025F,
    .base_u_m = 0.0400F,
    .base_v_m = -0.02309F,
    .cos_leg = {-0.258819045F, 0.965925826F, -0.707106781F},  // 105, -15, -135 degrees
    .sin_leg = {0.965925826F, -0.258819045F, -0.707106781F},
    .counts_per_rad = 1572.56250F,  // 320 slots x 4 x 110 mm / 14.25 mm / (2 pi)
    .theta_zero_rad = 35.0F * DEGREE,
    .theta_min_rad = -25.0F * DEGREE,
    .theta_max_rad = 90.0F * DEGREE,
    .units_per_n_m = 4200.0F,
    .motor_max = 4095,
};
