/// A simulated hand: an impedance (mass, spring, damper) whose equilibrium runs along a path. It homes the
/// device first, as a person would, then waits at the path's start, then follows the path. It carries the
/// effector's weight. A hand without stiffness cannot home: then a helper leads the grip to the path's start
/// and lets go of it when the path begins (assumed: somebody homes a device before nobody holds it).
#pragma once
#include <stdbool.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

/// Where a hand pushes to for homing: a little beyond the homing reference, device frame.
#define PAL_HAND_HOME_IN_Z_M 0.070

typedef struct pal_hand_point {
    double t_s;      ///< since the path began; increasing
    double at_m[3];  ///< tool centre that the hand wants, device frame
} pal_hand_point;

typedef struct pal_hand_config {
    double mass_kg, stiffness_n_per_m,
        damping_n_s_per_m;  ///< light 0.05 150 2, firm 0.15 500 8 (assumed); 0 0 0: no hand, once a helper
                            ///< let go
    double weight_n;        ///< effector's weight that the hand carries, along +y; 0 when there is no hand
    const pal_hand_point* path;  ///< borrowed; straight lines between points
    uint32_t n_points;
    uint32_t wait_ticks;  ///< between homing and the path's start: the start ramp and the way there
    double home_in_m[3];  ///< where the hand pushes to while the device homes, device frame
} pal_hand_config;

typedef struct pal_hand {
    pal_hand_config config;
    uint32_t tick;
    uint32_t homed_tick;  ///< tick at which homing was complete; 0: not yet
    uint32_t path_tick;   ///< ticks since the path began, 1 = 1 ms into it; 0 before
    uint32_t segment;     ///< of the path, index of its first point
    double from_m[3];     ///< where the present smooth move began: first at power-on, then where homing ended
    double target_m[3], target_velocity_m_per_s[3];
} pal_hand;

void pal_hand_init(pal_hand* hand, const pal_hand_config* config);
/// Moves the equilibrium on by 1 ms. `homed`: the device says so; when it no longer does, the hand homes it
/// again and begins its path anew. `at_m`: where the effector is.
void pal_hand_advance(pal_hand* hand, bool homed, const double at_m[3]);
/// The hand's force at a position and velocity; context is the pal_hand.
void pal_hand_push(const void* context, const double position_m[3], const double velocity_m_per_s[3],
                   double force_n[3]);

#ifdef __cplusplus
}
#endif
