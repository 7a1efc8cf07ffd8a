// palpate-falcon force-check: the map from a force to motor words against the work that these words do.
//
// The words are the driver's own (pal_force_words). Truth: arm angles by the inverse kinematics in double
// precision (docs/PROTOCOL.md 4 has the constants), their derivatives by central differences. Words m mean
// torques -m / K; their work along x, divided by the way, is the force that the hand feels. No Jacobian is
// used for that, so a wrong one is found.
#include <math.h>
#include <stdio.h>

#include "firmware/app/falcon_cli.h"
#include "firmware/core/delta.h"
#include "firmware/falcon/force.h"

enum { N_POSES = 8, N_FORCES = 3, AXES = 3 };
static const double FORCE_N = 4.0;
static const double STEP_M = 1e-6;
static const double FLOAT_ERROR_N = 0.002;  // what single precision may add to whole words

// Of the Falcon, whose centre is at (0, 0, 0.12) m; another delta has them at its own centre, as much larger
// as its arms are longer.
static const double POSES_M[N_POSES][AXES] = {{0.0, 0.0, 0.08},    {0.0, 0.0, 0.11},   {0.0, 0.0, 0.125},
                                              {0.0, 0.0, 0.15},    {0.02, 0.01, 0.12}, {-0.03, 0.02, 0.10},
                                              {0.03, -0.03, 0.14}, {0.0, 0.04, 0.11}};

static bool angles_rad(const pal_delta* g, const double at_m[AXES], double theta_rad[AXES]) {
    const double a = (double)g->arm_m;
    const double b = (double)g->forearm_m;
    for (int i = 0; i < AXES; ++i) {
        const double c = (double)g->cos_leg[i];
        const double s = (double)g->sin_leg[i];
        const double u = at_m[0] * c + at_m[1] * s - (double)g->base_u_m + (double)g->platform_u_m;
        const double v = -at_m[0] * s + at_m[1] * c - (double)g->base_v_m + (double)g->platform_v_m;
        const double k = (double)g->offset_m + sqrt(b * b - v * v);
        const double rho = sqrt(u * u + at_m[2] * at_m[2]);
        theta_rad[i] = atan2(at_m[2], u) - acos((rho * rho + a * a - k * k) / (2.0 * a * rho));
        if (!isfinite(theta_rad[i])) return false;
    }
    return true;
}

// rad/m: how far each arm turns when the hand moves along each axis.
static bool turns(const pal_delta* g, const double at_m[AXES], double rad_per_m[AXES][AXES]) {
    for (int c = 0; c < AXES; ++c) {
        double low[AXES];
        double high[AXES];
        double at[AXES] = {at_m[0], at_m[1], at_m[2]};
        at[c] = at_m[c] - STEP_M;
        if (!angles_rad(g, at, low)) return false;
        at[c] = at_m[c] + STEP_M;
        if (!angles_rad(g, at, high)) return false;
        for (int i = 0; i < AXES; ++i) rad_per_m[i][c] = (high[i] - low[i]) / (2.0 * STEP_M);
    }
    return true;
}

typedef struct row {
    double wanted_n[AXES], felt_n[AXES], error_n;
    double words_error_n;  ///< what whole words alone may make
    int16_t words[AXES];
} row;

// The share of the torques that the motor words can say.
static double fitting(const pal_delta* g, const float torque_n_m[AXES]) {
    double largest = 0.0;
    for (int i = 0; i < AXES; ++i)
        largest = fmax(largest, fabs((double)torque_n_m[i]) * (double)g->units_per_n_m);
    return largest > (double)g->motor_max ? (double)g->motor_max / largest : 1.0;
}

// The words that the driver sends once its ramp is over, with motors that are cold.
static bool words_of(const pal_delta* g, const float at_m[AXES], const float force_n[AXES],
                     int16_t words[AXES]) {
    const pal_force_config config = {.force_max_n = (float)FORCE_N,
                                     .ramp_us = 0,
                                     .rms_max_counts = (float)g->motor_max,
                                     .rms_time_s = 1.0F,
                                     .rms_margin = 1.0F};
    pal_force state = {.ramped_us = 0};
    float applied_n[AXES];
    const uint32_t faults = pal_force_words(&config, g, &state, at_m, force_n, (float)FORCE_N, applied_n);
    for (int i = 0; i < AXES; ++i) words[i] = state.words[i];
    return (faults & ~(uint32_t)PAL_FORCE_SATURATED) == 0;
}

// One force at one pose: what the driver sends, what it does.
static bool check(const pal_delta* g, const double at_m[AXES], int axis, const double rad_per_m[AXES][AXES],
                  row* out) {
    const float at[AXES] = {(float)at_m[0], (float)at_m[1], (float)at_m[2]};
    float force_n[AXES] = {0.0F, 0.0F, 0.0F};
    float torque_n_m[AXES];
    force_n[axis] = (float)FORCE_N;
    if (!pal_delta_torque(g, at, force_n, torque_n_m) || !words_of(g, at, force_n, out->words)) return false;
    const double share = fitting(g, torque_n_m);
    double squared = 0.0;
    double words_squared = 0.0;
    for (int c = 0; c < AXES; ++c) {
        out->wanted_n[c] = share * (double)force_n[c];
        out->felt_n[c] = 0.0;
        double half_words_n = 0.0;
        for (int i = 0; i < AXES; ++i) {
            out->felt_n[c] += -(double)out->words[i] / (double)g->units_per_n_m * rad_per_m[i][c];
            half_words_n += 0.5 / (double)g->units_per_n_m * fabs(rad_per_m[i][c]);
        }
        const double error = out->felt_n[c] - out->wanted_n[c];
        squared += error * error;
        words_squared += half_words_n * half_words_n;
    }
    out->error_n = sqrt(squared);
    out->words_error_n = sqrt(words_squared);
    return true;
}

// The largest difference of the driver's Jacobian from the turns, over the largest turn; 1 when it has none.
static double jacobian_error(const pal_delta* g, const double at_m[AXES],
                             const double rad_per_m[AXES][AXES]) {
    const float at[AXES] = {(float)at_m[0], (float)at_m[1], (float)at_m[2]};
    float jacobian[AXES * AXES];
    if (!pal_delta_jacobian(g, at, jacobian)) return 1.0;
    double largest = 0.0;
    double worst = 0.0;
    for (int i = 0; i < AXES * AXES; ++i) {
        const double truth = rad_per_m[i / AXES][i % AXES];
        largest = fmax(largest, fabs(truth));
        worst = fmax(worst, fabs((double)jacobian[i] - truth));
    }
    return worst / largest;
}

static void print_row(const pal_falcon_options* options, const double at_m[AXES], const row* r, bool first) {
    if (options->json) {
        (void)printf(
            "%s\n  {\"position_m\": [%g, %g, %g], \"wanted_n\": [%g, %g, %g], \"motor_counts\": [%d, %d, "
            "%d], "
            "\"felt_n\": [%.6f, %.6f, %.6f], \"error_n\": %.6f}",
            first ? "" : ",", at_m[0], at_m[1], at_m[2], r->wanted_n[0], r->wanted_n[1], r->wanted_n[2],
            r->words[0], r->words[1], r->words[2], r->felt_n[0], r->felt_n[1], r->felt_n[2], r->error_n);
        return;
    }
    (void)printf("%6.0f %5.0f %5.0f  %5.1f %4.1f %4.1f  %6d %6d %6d  %8.4f %8.4f %8.4f  %8.4f\n",
                 1e3 * at_m[0], 1e3 * at_m[1], 1e3 * at_m[2], r->wanted_n[0], r->wanted_n[1], r->wanted_n[2],
                 r->words[0], r->words[1], r->words[2], r->felt_n[0], r->felt_n[1], r->felt_n[2], r->error_n);
}

static void print_start(const pal_falcon_options* options, const pal_delta* g) {
    if (options->json) {
        (void)printf("{\"schema\": \"palpate.falcon_force_check/1\", \"units_per_n_m\": %g, \"rows\": [",
                     (double)g->units_per_n_m);
        return;
    }
    (void)printf(
        "The force that the words do by virtual work, against the force that was wanted.\n\n"
        "       at, mm         wanted, N          words             felt, N                   error, "
        "N\n");
}

// What all rows come to.
typedef struct verdict {
    double force_error_n, words_error_n, turn_error;  ///< the largest
    int n_rows;
    bool good;
} verdict;

static void print_end(const pal_falcon_options* options, const pal_delta* g, const verdict* v) {
    if (options->json) {
        (void)printf("], \"force_error_max_n\": %.6f, \"jacobian_error_max\": %.3g, \"good\": %s}\n",
                     v->force_error_n, v->turn_error, v->good ? "true" : "false");
        return;
    }
    (void)printf(
        "\nlargest error of a force %.4f N (whole words alone may make %.4f), of the Jacobian %.2g of its "
        "largest "
        "entry\n%s. Force scale: %g units per N m, assumed, +-15 %%, until calibrated with a weight on a "
        "real grip.\n",
        v->force_error_n, v->words_error_n, v->turn_error,
        v->good ? "good" : "bad: this build must not drive a device", (double)g->units_per_n_m);
}

// All forces at one pose. False: the driver refuses a pose that the truth reaches. What the truth does not
// reach is left out: another delta may have another shape.
static bool check_pose(const pal_falcon_options* options, const pal_delta* g, const double at_m[AXES],
                       verdict* v) {
    double rad_per_m[AXES][AXES];
    if (!turns(g, at_m, rad_per_m)) return true;
    v->turn_error = fmax(v->turn_error, jacobian_error(g, at_m, (const double(*)[AXES])rad_per_m));
    for (int axis = 0; axis < N_FORCES; ++axis) {
        row r;
        if (!check(g, at_m, axis, (const double(*)[AXES])rad_per_m, &r)) return false;
        v->force_error_n = fmax(v->force_error_n, r.error_n);
        v->words_error_n = fmax(v->words_error_n, r.words_error_n);
        v->good = v->good && r.error_n <= r.words_error_n + FLOAT_ERROR_N;
        print_row(options, at_m, &r, v->n_rows == 0);
        v->n_rows += 1;
    }
    return true;
}

int pal_falcon_force_check(const pal_falcon_options* options) {
    pal_delta_file file;
    pal_delta_file falcon = {.centre_m = {0.0F}};
    char why[PAL_DELTA_WORDS_BYTES];
    if (!pal_cli_delta(options, &file) || !pal_delta_file_read(NULL, &falcon, why)) return PAL_EXIT_ARGUMENTS;
    const double larger = (double)file.delta.arm_m / (double)falcon.delta.arm_m;
    verdict v = {.good = true};
    print_start(options, &file.delta);
    for (int p = 0; p < N_POSES; ++p) {
        double at_m[AXES];
        for (int c = 0; c < AXES; ++c) {
            at_m[c] =
                larger * POSES_M[p][c] + ((double)file.centre_m[c] - larger * (double)falcon.centre_m[c]);
        }
        v.good = check_pose(options, &file.delta, at_m, &v) && v.good;
    }
    v.good = v.good && v.n_rows > 0 && v.turn_error <= 1e-4;
    print_end(options, &file.delta, &v);
    return v.good ? PAL_EXIT_DONE : PAL_EXIT_VERDICT;
}
