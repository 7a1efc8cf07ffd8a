/// Kinematics and statics of a three-arm delta such as the Novint Falcon (Stamper, PhD 97-4, ch. 3-4). Device
/// frame: x right, y up, z out of the device towards the user, metres, origin at the base plate. No libm but
/// sqrt.
#pragma once
#include <stdbool.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

/// Geometry and gains: data, so that a scaled delta works unchanged.
typedef struct pal_delta {
    float arm_m;                         ///< a: motor-driven link
    float forearm_m;                     ///< b: parallelogram, long side
    float offset_m;                      ///< d + e: both ends of the parallelogram together
    float platform_u_m, platform_v_m;    ///< c, f: joint to platform centre
    float base_u_m, base_v_m;            ///< r, s: origin to motor axis
    float cos_leg[3], sin_leg[3];        ///< direction of each leg in the x-y plane
    float counts_per_rad;                ///< encoder
    float theta_zero_rad;                ///< arm angle at encoder 0
    float theta_min_rad, theta_max_rad;  ///< travel of an arm; outside it: out of the workspace
    float units_per_n_m;  ///< motor words per N m of arm torque; positive words pull towards smaller theta
    int16_t motor_max;    ///< saturation of a motor word
} pal_delta;

/// Novint Falcon NF1 (docs/PROTOCOL.md 4 has the source of each number).
extern const pal_delta PAL_DELTA_NF1;

/// Arm angle at an encoder reading, and the nearest reading at an angle (false where it does not fit 16
/// bits).
float pal_delta_theta_rad(const pal_delta* g, int16_t counts);
bool pal_delta_counts(const pal_delta* g, float theta_rad, int16_t* counts);

/// Position from arm angles: two full Newton steps from `near_m` (the last position; the workspace middle at
/// first, with `n_steps` up to 12). A step is at most 20 mm; a step that leaves the mechanism's domain is
/// halved up to six times. False, `out_m` untouched: an arm beyond its travel, no way back into the domain,
/// or a last step above 0.1 mm.
bool pal_delta_forward(const pal_delta* g, const float theta_rad[3], const float near_m[3], int n_steps,
                       float out_m[3]);
/// Arm angles at a position (the branch with the elbow out). False, output untouched, outside the workspace.
bool pal_delta_inverse(const pal_delta* g, const float at_m[3], float theta_rad[3]);
/// Rows: d theta_i / d (x, y, z), rad/m. False at singular positions.
bool pal_delta_jacobian(const pal_delta* g, const float at_m[3], float jacobian[9]);
/// Arm torques (N m) that make `force_n` on the hand: tau = J^-T F. False at singular positions.
bool pal_delta_torque(const pal_delta* g, const float at_m[3], const float force_n[3], float torque_n_m[3]);

#ifdef __cplusplus
}
#endif
