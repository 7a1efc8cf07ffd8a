/// True kinematics of the simulated delta at a Falcon's size, from its closure equation: solved numerically,
/// differentiated implicitly.
#pragma once
#include <stdbool.h>
#ifdef __cplusplus
extern "C" {
#endif

enum { PAL_FALCON_ARMS = 3 };

extern const double PAL_FALCON_THETA_MIN_RAD,
    PAL_FALCON_THETA_MAX_RAD;  ///< travel of an arm: -25 and +90 degrees

/// Sine and cosine for |angle| <= pi, error below 2e-16. Own polynomials: the same bits everywhere.
void pal_falcon_sin_cos(double angle_rad, double* sine, double* cosine);

/// Arm angles at a position, with the elbow out. `near_rad` (may be `theta_rad`): angles close by save time,
/// nothing else. False, output untouched, outside the workspace.
bool pal_falcon_solve_theta(const double at_m[3], const double near_rad[3], double theta_rad[3]);
/// Rows: d theta_i / d (x, y, z) at a position and its arm angles.
void pal_falcon_theta_gradient(const double at_m[3], const double theta_rad[3], double jacobian[9]);

#ifdef __cplusplus
}
#endif
