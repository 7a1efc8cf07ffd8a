#include "firmware/core/delta.h"

#include <math.h>

#include "firmware/core/trig.h"

static const float STEP_MAX_M =
    0.02F;  // a longer Newton step overshoots the domain (it does in 2.6 % of cold starts)
static const float CONVERGED_M = 1.0e-4F;  // last step; the error left is its square times about 20/m
static const float SETTLED_M = 1.0e-6F;    // the next step would be below one rounding
static const float SINE_MIN = 0.02F;    // floor of sin(theta3) sin(theta2 - theta1): leg stretched or folded
static const float VOLUME_MIN = 0.02F;  // floor of |det J| over the product of its row norms
enum { HALVINGS_MAX = 6 };

// One leg at a position: cosines and sines of theta1 (arm), theta2 and theta3 (forearm).
typedef struct leg {
    float cos1, sin1, cos2, sin2, cos3, sin3;
} leg;

static float sine_from(float cosine) {
    return sqrtf((1.0F - cosine) * (1.0F + cosine));
}

static bool inside_unit(float x) {
    return x > -1.0F && x < 1.0F;
}

static bool leg_at(const pal_delta* g, int i, const float at_m[3], leg* out) {
    const float c = g->cos_leg[i];
    const float s = g->sin_leg[i];
    const float u = at_m[0] * c + at_m[1] * s - g->base_u_m + g->platform_u_m;
    const float v = at_m[1] * c - at_m[0] * s - g->base_v_m + g->platform_v_m;
    const float w = at_m[2];
    out->cos3 = v / g->forearm_m;
    if (!inside_unit(out->cos3)) return false;
    out->sin3 = sine_from(out->cos3);
    const float a = g->arm_m;
    const float k = g->offset_m + g->forearm_m * out->sin3;
    const float rho2 = u * u + w * w;
    const float rho = sqrtf(rho2);
    const float cos_lag = (rho2 + a * a - k * k) / (2.0F * a * rho);  // law of cosines at the motor axis
    if (!inside_unit(cos_lag)) return false;
    const float sin_lag = sine_from(cos_lag);
    out->cos1 = (u * cos_lag + w * sin_lag) / rho;
    out->sin1 = (w * cos_lag - u * sin_lag) / rho;
    out->cos2 = (u - a * out->cos1) / k;
    out->sin2 = (w - a * out->sin1) / k;
    return true;
}

// Stamper (4.9)-(4.12): the row of d theta1 / d (x, y, z).
static bool leg_row(const pal_delta* g, int i, const leg* at, float row[3]) {
    const float sine = at->sin3 * (at->sin2 * at->cos1 - at->cos2 * at->sin1);
    if (!(sine > SINE_MIN)) return false;
    const float scale = 1.0F / (g->arm_m * sine);
    const float in_plane = at->cos2 * at->sin3;
    row[0] = (g->cos_leg[i] * in_plane - g->sin_leg[i] * at->cos3) * scale;
    row[1] = (g->sin_leg[i] * in_plane + g->cos_leg[i] * at->cos3) * scale;
    row[2] = at->sin2 * at->sin3 * scale;
    return true;
}

static void cross(const float a[3], const float b[3], float out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static float dot(const float a[3], const float b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Columns of the inverse of the matrix with rows r, by cofactors; false when the rows are nearly in one
// plane.
static bool invert(const float r[9], float column[3][3]) {
    cross(r + 3, r + 6, column[0]);
    cross(r + 6, r, column[1]);
    cross(r, r + 3, column[2]);
    const float det = dot(r, column[0]);
    const float norms = sqrtf(dot(r, r)) * sqrtf(dot(r + 3, r + 3)) * sqrtf(dot(r + 6, r + 6));
    if (!(det > VOLUME_MIN * norms || det < -VOLUME_MIN * norms)) return false;
    for (int i = 0; i < 3; ++i) {
        for (int c = 0; c < 3; ++c) column[i][c] /= det;
    }
    return true;
}

float pal_delta_theta_rad(const pal_delta* g, int16_t counts) {
    return g->theta_zero_rad + (float)counts / g->counts_per_rad;
}

bool pal_delta_counts(const pal_delta* g, float theta_rad, int16_t* counts) {
    const float reading = (theta_rad - g->theta_zero_rad) * g->counts_per_rad;
    if (!(reading >= -32768.0F && reading <= 32767.0F)) return false;
    *counts = (int16_t)(reading < 0.0F ? reading - 0.5F : reading + 0.5F);
    return true;
}

bool pal_delta_inverse(const pal_delta* g, const float at_m[3], float theta_rad[3]) {
    float theta[3];
    for (int i = 0; i < 3; ++i) {
        leg at;
        if (!leg_at(g, i, at_m, &at)) return false;
        theta[i] = pal_atan2(at.sin1, at.cos1);
    }
    for (int i = 0; i < 3; ++i) theta_rad[i] = theta[i];
    return true;
}

bool pal_delta_jacobian(const pal_delta* g, const float at_m[3], float jacobian[9]) {
    for (int i = 0; i < 3; ++i) {
        leg at;
        if (!leg_at(g, i, at_m, &at) || !leg_row(g, i, &at, jacobian + 3 * i)) return false;
    }
    return true;
}

bool pal_delta_torque(const pal_delta* g, const float at_m[3], const float force_n[3], float torque_n_m[3]) {
    float jacobian[9];
    float column[3][3];
    if (!pal_delta_jacobian(g, at_m, jacobian) || !invert(jacobian, column)) return false;
    for (int i = 0; i < 3; ++i) torque_n_m[i] = dot(column[i], force_n);  // J^T tau = F
    return true;
}

// Where the arms are measured to be.
typedef struct aim {
    float cosine[3], sine[3];
} aim;

// The Newton step from `at_m`: J^-1 (theta measured - theta there).
static bool newton_step(const pal_delta* g, const aim* to, const float at_m[3], float step_m[3]) {
    float jacobian[9];
    float column[3][3];
    float miss_rad[3];
    for (int i = 0; i < 3; ++i) {
        leg at;
        if (!leg_at(g, i, at_m, &at) || !leg_row(g, i, &at, jacobian + 3 * i)) return false;
        miss_rad[i] = pal_atan2(to->sine[i] * at.cos1 - to->cosine[i] * at.sin1,
                                to->cosine[i] * at.cos1 + to->sine[i] * at.sin1);
    }
    if (!invert(jacobian, column)) return false;
    for (int c = 0; c < 3; ++c) {
        step_m[c] = column[0][c] * miss_rad[0] + column[1][c] * miss_rad[1] + column[2][c] * miss_rad[2];
    }
    return true;
}

bool pal_delta_forward(const pal_delta* g, const float theta_rad[3], const float near_m[3], int n_steps,
                       float out_m[3]) {
    aim to;
    for (int i = 0; i < 3; ++i) {
        if (!(theta_rad[i] >= g->theta_min_rad && theta_rad[i] <= g->theta_max_rad)) return false;
        to.cosine[i] = pal_cos(theta_rad[i]);
        to.sine[i] = pal_sin(theta_rad[i]);
    }
    float at[3] = {near_m[0], near_m[1], near_m[2]};
    float back[3] = {0.0F, 0.0F, 0.0F};  // the step that led here
    float length = 2.0F * CONVERGED_M;
    for (int n = 0; n < n_steps && !(length <= SETTLED_M); ++n) {
        float step[3];
        bool ok = newton_step(g, &to, at, step);
        for (int h = 0; !ok && n > 0 && h < HALVINGS_MAX; ++h) {
            for (int c = 0; c < 3; ++c) {
                back[c] *= 0.5F;
                at[c] -= back[c];
            }
            ok = newton_step(g, &to, at, step);
        }
        if (!ok) return false;
        length = sqrtf(dot(step, step));
        const float part = length > STEP_MAX_M ? STEP_MAX_M / length : 1.0F;
        for (int c = 0; c < 3; ++c) {
            back[c] = step[c] * part;
            at[c] += back[c];
        }
    }
    if (!(length <= CONVERGED_M)) return false;
    for (int c = 0; c < 3; ++c) out_m[c] = at[c];
    return true;
}
