/// Sine, cosine and arc tangent in float from fixed polynomials: the same bits on every compiler and libm.
#pragma once
#ifdef __cplusplus
extern "C" {
#endif

enum { PAL_TRIG_MAX_RAD = 1000 };  ///< arguments beyond give NaN

/// Absolute error below 1e-7 for |x| <= 4 rad, below 2e-7 to PAL_TRIG_MAX_RAD. NaN and infinity give NaN.
float pal_sin(float x_rad);
float pal_cos(float x_rad);
/// In [-pi, pi], absolute error below 3e-7 (one rounding of pi is 1.2e-7). atan2(0, 0) = 0. NaN gives NaN.
float pal_atan2(float y, float x);

#ifdef __cplusplus
}
#endif
