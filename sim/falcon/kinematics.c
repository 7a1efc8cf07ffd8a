#include "sim/falcon/kinematics.h"

#include <math.h>

// Geometry of the NF1: docs/PROTOCOL.md 4.
static const double ARM_M = 0.060, FOREARM_M = 0.1025, OFFSET_M = 0.0225;        // a, b, d + e
static const double REACH_U_M = 0.01443 - 0.0400, REACH_V_M = -0.025 + 0.02309;  // c - r, f - s
// Legs at 105, -15 and -135 degrees.
static const double LEG_COS[3] = {-0.25881904510252076, 0.96592582628906829, -0.70710678118654752};
static const double LEG_SIN[3] = {0.96592582628906829, -0.25881904510252076, -0.70710678118654752};

static const double PI_HALF = 1.57079632679489662, PI_HALF_LOW = 6.123233995736766e-17;
const double PAL_FALCON_THETA_MIN_RAD = -0.43633231299858239, PAL_FALCON_THETA_MAX_RAD = 1.57079632679489662;
static const double COS_MIN = 0.90630778703664996, SIN_MIN = -0.42261826174069944;  // of -25 degrees

static const double SIDE_MAX = 0.98;   // |V| / b: beyond it a parallelogram folds
static const double ELBOW_MIN = 0.05;  // sine between arm and forearm: below it a leg is stretched
static const double FAR_M = 1.0;       // no leg reaches so far
static const double STEP_END_RAD = 1e-15;
static const double RESIDUAL_MAX_M2 = 1e-15;
enum { N_STEPS_MAX = 80 };

/// Taylor series on |x| <= pi/4; the first term left out is below 5e-17.
static void sin_cos_small(double x, double* sine, double* cosine) {
    static const double S[] = {-1.0 / 6.0,        1.0 / 120.0,        -1.0 / 5040.0,         1.0 / 362880.0,
                               -1.0 / 39916800.0, 1.0 / 6227020800.0, -1.0 / 1307674368000.0};
    static const double C[] = {
        -1.0 / 2.0,       1.0 / 24.0,        -1.0 / 720.0,         1.0 / 40320.0,
        -1.0 / 3628800.0, 1.0 / 479001600.0, -1.0 / 87178291200.0, 1.0 / 20922789888000.0};
    const double xx = x * x;
    double s = 0.0;
    double c = 0.0;
    for (int i = 6; i >= 0; --i) s = (s + S[i]) * xx;
    for (int i = 7; i >= 0; --i) c = (c + C[i]) * xx;
    *sine = x + x * s;
    *cosine = 1.0 + c;
}

void pal_falcon_sin_cos(double angle_rad, double* sine, double* cosine) {
    const int n_quarters = (int)(angle_rad / PI_HALF + 4.5) - 4;  // nearest, -2 .. 2
    const double quarters = (double)n_quarters;
    const double rest = (angle_rad - quarters * PI_HALF) - quarters * PI_HALF_LOW;
    double s;
    double c;
    sin_cos_small(rest, &s, &c);
    const int q = (n_quarters + 4) % 4;
    const double sines[4] = {s, c, -s, -c};
    const double cosines[4] = {c, -s, -c, s};
    *sine = sines[q];
    *cosine = cosines[q];
}

/// One leg's plane at a position: joint coordinates and the forearm's length in it.
typedef struct leg {
    double u, v, w, k;
} leg;

/// k is NaN where has_answer is false for a large |V|.
static leg leg_at(int i, const double at_m[3]) {
    leg l;
    l.u = at_m[0] * LEG_COS[i] + at_m[1] * LEG_SIN[i] + REACH_U_M;
    l.v = at_m[1] * LEG_COS[i] - at_m[0] * LEG_SIN[i] + REACH_V_M;
    l.w = at_m[2];
    l.k = OFFSET_M + sqrt(FOREARM_M * FOREARM_M - l.v * l.v);
    return l;
}

static bool has_answer(const leg* l) {
    return fabs(l->v) < SIDE_MAX * FOREARM_M && fabs(l->u) < FAR_M && fabs(l->w) < FAR_M;
}

/// g = (U - a cos t)^2 + (W - a sin t)^2 - k^2 and dg/dt.
static double closure(const leg* l, double sine, double cosine, double* slope) {
    const double du = l->u - ARM_M * cosine;
    const double dw = l->w - ARM_M * sine;
    *slope = 2.0 * ARM_M * (l->u * sine - l->w * cosine);
    return du * du + dw * dw - l->k * l->k;
}

/// Below the wanted root g > 0 and falls; from it up to the stretched leg g <= 0; beyond that g rises.
static bool is_below(double g, double slope) {
    return g > 0.0 && slope < 0.0;
}

/// Newton's method, and bisection wherever it would leave the bracket (the arm's travel).
static bool solve_leg(const leg* l, double near_rad, double* theta_rad) {
    double slope;
    double g = closure(l, SIN_MIN, COS_MIN, &slope);
    if (!is_below(g, slope) && g != 0.0) return false;
    g = closure(l, 1.0, 0.0, &slope);
    if (is_below(g, slope)) return false;
    double low = PAL_FALCON_THETA_MIN_RAD;
    double high = PAL_FALCON_THETA_MAX_RAD;
    double t = near_rad >= low && near_rad <= high ? near_rad : 0.5 * (low + high);
    for (int n = 0; n < N_STEPS_MAX; ++n) {
        double s;
        double c;
        pal_falcon_sin_cos(t, &s, &c);
        g = closure(l, s, c, &slope);
        if (is_below(g, slope)) {
            low = t;
        } else {
            high = t;
        }
        double next = slope < 0.0 ? t - g / slope : low;
        if (!(next > low && next < high)) next = fabs(next - t) <= STEP_END_RAD ? t : 0.5 * (low + high);
        const double step = fabs(next - t);
        t = next;
        if (step <= STEP_END_RAD) break;
    }
    if (!(fabs(g) <= RESIDUAL_MAX_M2) || !(-slope >= 2.0 * ARM_M * l->k * ELBOW_MIN)) return false;
    *theta_rad = t;
    return true;
}

bool pal_falcon_solve_theta(const double at_m[3], const double near_rad[3], double theta_rad[3]) {
    double found[3];
    for (int i = 0; i < PAL_FALCON_ARMS; ++i) {
        const leg l = leg_at(i, at_m);
        if (!has_answer(&l) || !solve_leg(&l, near_rad[i], &found[i])) return false;
    }
    for (int i = 0; i < PAL_FALCON_ARMS; ++i) theta_rad[i] = found[i];
    return true;
}

void pal_falcon_theta_gradient(const double at_m[3], const double theta_rad[3], double jacobian[9]) {
    for (int i = 0; i < PAL_FALCON_ARMS; ++i) {
        double s;
        double c;
        double slope;
        pal_falcon_sin_cos(theta_rad[i], &s, &c);
        const leg l = leg_at(i, at_m);
        (void)closure(&l, s, c, &slope);
        // G(t, P) = 0: dt/dP = -G_P / G_t; k dk/dV = -k V / (k - d - e).
        const double g_u = 2.0 * (l.u - ARM_M * c);
        const double g_w = 2.0 * (l.w - ARM_M * s);
        const double g_v = 2.0 * l.k * l.v / (l.k - OFFSET_M);
        jacobian[3 * i + 0] = -(g_u * LEG_COS[i] - g_v * LEG_SIN[i]) / slope;
        jacobian[3 * i + 1] = -(g_u * LEG_SIN[i] + g_v * LEG_COS[i]) / slope;
        jacobian[3 * i + 2] = -g_w / slope;
    }
}
