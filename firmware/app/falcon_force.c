// palpate-falcon force-check: the map from a force to motor words against the work that these words do.
//
// Truth: arm angles by the inverse kinematics in double precision (docs/PROTOCOL.md 4 has the constants),
// their derivatives by central differences. Words m mean torques -m / K; their work along x, divided by the
// way, is the force that the hand feels. No Jacobian is used for that, so a wrong one is found.
#include <math.h>
#include <stdio.h>

#include "firmware/app/falcon_cli.h"
#include "firmware/core/delta.h"

enum { N_POSES = 8, N_FORCES = 3, AXES = 3 };
static const double FORCE_N = 4.0;
static const double STEP_M = 1e-6;
/// A word is a whole number: half a unit on each arm, through the Jacobian's largest row sum here, is 0.012
/// N.
static const double ERROR_MAX_N = 0.02;

static const double POSES_M[N_POSES][AXES] = {{0.0, 0.0, 0.08},    {0.0, 0.0, 0.11},   {0.0, 0.0, 0.125},
                                              {0.0, 0.0, 0.15},    {0.02, 0.01, 0.12}, {-0.03, 0.02, 0.10},
                                              {0.03, -0.03, 0.14}, {0.0, 0.04, 0.11}};

static bool angles_rad(const double at_m[AXES], double theta_rad[AXES]) {
    const pal_delta* g = &PAL_DELTA_NF1;
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
static bool turns(const double at_m[AXES], double rad_per_m[AXES][AXES]) {
    for (int c = 0; c < AXES; ++c) {
        double low[AXES];
        double high[AXES];
        double at[AXES] = {at_m[0], at_m[1], at_m[2]};
        at[c] = at_m[c] - STEP_M;
        if (!angles_rad(at, low)) return false;
        at[c] = at_m[c] + STEP_M;
        if (!angles_rad(at, high)) return false;
        for (int i = 0; i < AXES; ++i) rad_per_m[i][c] = (high[i] - low[i]) / (2.0 * STEP_M);
    }
    return true;
}

typedef struct row {
    double wanted_n[AXES], felt_n[AXES], error_n;
    int16_t words[AXES];
} row;

// One force at one pose: what the driver sends, what it does.
static bool check(const double at_m[AXES], int axis, const double rad_per_m[AXES][AXES], row* out) {
    const pal_delta* g = &PAL_DELTA_NF1;
    const float at[AXES] = {(float)at_m[0], (float)at_m[1], (float)at_m[2]};
    float force_n[AXES] = {0.0F, 0.0F, 0.0F};
    float torque_n_m[AXES];
    force_n[axis] = (float)FORCE_N;
    if (!pal_delta_torque(g, at, force_n, torque_n_m)) return false;
    double squared = 0.0;
    for (int i = 0; i < AXES; ++i) {
        out->words[i] = (int16_t)lrint(-(double)torque_n_m[i] * (double)g->units_per_n_m);
    }
    for (int c = 0; c < AXES; ++c) {
        out->wanted_n[c] = (double)force_n[c];
        out->felt_n[c] = 0.0;
        for (int i = 0; i < AXES; ++i) {
            out->felt_n[c] += -(double)out->words[i] / (double)g->units_per_n_m * rad_per_m[i][c];
        }
        const double error = out->felt_n[c] - out->wanted_n[c];
        squared += error * error;
    }
    out->error_n = sqrt(squared);
    return true;
}

// The largest relative difference of the driver's Jacobian from the turns.
static double jacobian_error(const double at_m[AXES], const double rad_per_m[AXES][AXES]) {
    const float at[AXES] = {(float)at_m[0], (float)at_m[1], (float)at_m[2]};
    float jacobian[AXES * AXES];
    if (!pal_delta_jacobian(&PAL_DELTA_NF1, at, jacobian)) return (double)INFINITY;
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

static void print_end(const pal_falcon_options* options, double force_error_n, double turn_error, bool good) {
    if (options->json) {
        (void)printf("], \"force_error_max_n\": %.6f, \"jacobian_error_max\": %.3g, \"good\": %s}\n",
                     force_error_n, turn_error, good ? "true" : "false");
        return;
    }
    (void)printf(
        "\nlargest error of a force %.4f N (whole words alone may make %g), of the Jacobian %.2g of its "
        "largest "
        "entry\n%s. The gain of %g units per N m is taken as given: only a weight on a real grip can test "
        "it.\n",
        force_error_n, ERROR_MAX_N, turn_error, good ? "good" : "bad: this build must not drive a device",
        (double)PAL_DELTA_NF1.units_per_n_m);
}

int pal_falcon_force_check(const pal_falcon_options* options) {
    double force_error_n = 0.0;
    double turn_error = 0.0;
    if (options->json) {
        (void)printf("{\"schema\": \"palpate.falcon_force_check/1\", \"units_per_n_m\": %g, \"rows\": [",
                     (double)PAL_DELTA_NF1.units_per_n_m);
    } else {
        (void)printf(
            "The force that the words do by virtual work, against the force that was wanted.\n\n"
            "       at, mm         wanted, N          words             felt, N                   error, "
            "N\n");
    }
    for (int p = 0; p < N_POSES; ++p) {
        double rad_per_m[AXES][AXES];
        if (!turns(POSES_M[p], rad_per_m)) return PAL_EXIT_VERDICT;
        turn_error = fmax(turn_error, jacobian_error(POSES_M[p], (const double(*)[AXES])rad_per_m));
        for (int axis = 0; axis < N_FORCES; ++axis) {
            row r;
            if (!check(POSES_M[p], axis, (const double(*)[AXES])rad_per_m, &r)) return PAL_EXIT_VERDICT;
            force_error_n = fmax(force_error_n, r.error_n);
            print_row(options, POSES_M[p], &r, p == 0 && axis == 0);
        }
    }
    const bool good = force_error_n <= ERROR_MAX_N && turn_error <= 1e-4;
    print_end(options, force_error_n, turn_error, good);
    return good ? PAL_EXIT_DONE : PAL_EXIT_VERDICT;
}
