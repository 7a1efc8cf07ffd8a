#include "firmware/core/trig.h"

#include <math.h>
#include <stdbool.h>

// pi/2 in three parts; the first two have few enough bits that k times them is exact for k < 2^11.
static const float HALF_PI_1 = 1.5703125F, HALF_PI_2 = 4.837512969970703125e-4F,
                   HALF_PI_3 = 7.549789954892e-8F;
static const float TWO_OVER_PI = 0.636619772F;
static const float PI = 3.14159265F, PI_LOW = -8.74227766e-8F;  // pi = PI + PI_LOW
static const float HALF_PI = 1.57079633F, HALF_PI_LOW = -4.37113883e-8F;
static const float QUARTER_PI = 0.785398163F;
static const float TAN_EIGHTH_PI = 0.414213562F;

// Taylor on |r| <= pi/4: the first term left out is below 2e-9 (sine) and 1e-10 (cosine).
static float sine_near_zero(float r) {
    const float r2 = r * r;
    return r +
           r * r2 * (-1.0F / 6.0F + r2 * (1.0F / 120.0F + r2 * (-1.0F / 5040.0F + r2 * (1.0F / 362880.0F))));
}

static float cosine_near_zero(float r) {
    const float r2 = r * r;
    return 1.0F - 0.5F * r2 +
           r2 * r2 *
               (1.0F / 24.0F + r2 * (-1.0F / 720.0F + r2 * (1.0F / 40320.0F + r2 * (-1.0F / 3628800.0F))));
}

// sin(x + shift pi/2)
static float sine_of(float x, int shift) {
    if (!(x >= -(float)PAL_TRIG_MAX_RAD && x <= (float)PAL_TRIG_MAX_RAD)) return NAN;
    const float turns = x * TWO_OVER_PI;
    const int k = (int)(turns < 0.0F ? turns - 0.5F : turns + 0.5F);
    const float kf = (float)k;
    const float r = ((x - kf * HALF_PI_1) - kf * HALF_PI_2) - kf * HALF_PI_3;
    const unsigned quarter = (unsigned)(k + shift) & 3U;
    const float value = (quarter & 1U) != 0 ? cosine_near_zero(r) : sine_near_zero(r);
    return (quarter & 2U) != 0 ? -value : value;
}

float pal_sin(float x_rad) {
    return sine_of(x_rad, 0);
}

float pal_cos(float x_rad) {
    return sine_of(x_rad, 1);
}

// On 0 <= t <= 1. Taylor to t^17 on |t| <= tan(pi/8): the first term left out is below 3e-9.
static float arc_tangent(float t) {
    const bool high = t > TAN_EIGHTH_PI;
    const float r = high ? (t - 1.0F) / (t + 1.0F) : t;
    const float r2 = r * r;
    const float tail =
        r2 * (-1.0F / 3.0F +
              r2 * (1.0F / 5.0F +
                    r2 * (-1.0F / 7.0F +
                          r2 * (1.0F / 9.0F +
                                r2 * (-1.0F / 11.0F +
                                      r2 * (1.0F / 13.0F + r2 * (-1.0F / 15.0F + r2 * (1.0F / 17.0F))))))));
    const float angle = r + r * tail;
    return high ? QUARTER_PI + angle : angle;
}

float pal_atan2(float y, float x) {
    const float ax = x < 0.0F ? -x : x;
    const float ay = y < 0.0F ? -y : y;
    if (!(ax <= 3.0e38F && ay <= 3.0e38F)) return NAN;
    if (ax == 0.0F && ay == 0.0F) return 0.0F;
    float angle = ay <= ax ? arc_tangent(ay / ax) : HALF_PI - (arc_tangent(ax / ay) - HALF_PI_LOW);
    if (x < 0.0F) angle = PI - (angle - PI_LOW);
    return y < 0.0F ? -angle : angle;
}
