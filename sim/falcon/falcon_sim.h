/// A Falcon at the level of its 16-byte packets: mechanics, motors, encoders, homing, watchdog. Written from
/// the wire facts alone: it shares no code with the driver. Double precision, no libm but sqrt. Marked values
/// are assumptions.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

enum { PAL_FALCON_DELAY_MAX = 7, PAL_FALCON_MOTOR_MAX = 4095 };

typedef struct pal_falcon_sim_config {
    double scale;    ///< all lengths of the delta: so many times the Falcon's, 0.25..4; pal_falcon_sim_resize
    double mass_kg;  ///< effector, assumed 0.2
    double gravity_m_per_s2;   ///< along -y
    double viscous_n_s_per_m;  ///< assumed 2
    double coulomb_n;          ///< assumed 0.3
    double units_per_n_m;      ///< motor words per N m, assumed 4200
    double home_theta_rad;  ///< arm angle of the homing reference, near the inner stop; assumed -15 degrees
    double start_m[3];      ///< device frame, where the effector is at power-on
    int16_t start_offset_counts[3];  ///< what the counters read before homing is this much off
    uint32_t watchdog_ticks;         ///< without a packet for this long the motors go to zero; assumed 100
    uint32_t
        delay_ticks;  ///< a motor word acts this many ticks after it came; 1, at most PAL_FALCON_DELAY_MAX
    uint32_t n_substeps;   ///< of the mechanics within 1 ms
    bool homed_needs_bit;  ///< homed flags are told only while the homing bit is set; no source tells
    uint8_t reply_spare;   ///< byte 14 of a reply, minus 'A': 0..15; no source tells what it means
} pal_falcon_sim_config;

pal_falcon_sim_config pal_falcon_sim_config_default(void);
/// Another delta: its links, base and platform are `scale` times a Falcon's, and start_m with them. Mass,
/// frictions, motors, encoders, angles and the hardness of the stops at the grip stay as they are.
void pal_falcon_sim_resize(pal_falcon_sim_config* config, double scale);
/// Draws what differs from device to device and from power-on to power-on: what the counters read before
/// homing.
void pal_falcon_sim_seed(pal_falcon_sim_config* config, uint64_t seed);
/// Another device of the same kind: mass, both frictions and the motors' gain are each multiplied by a factor
/// in 1 - spread .. 1 + spread, `spread` in [0, 1), such as 0.3; the counters as by pal_falcon_sim_seed.
void pal_falcon_sim_vary(pal_falcon_sim_config* config, uint64_t seed, double spread);

typedef struct pal_falcon_sim {
    pal_falcon_sim_config config;
    double position_m[3], velocity_m_per_s[3];  ///< device frame
    double theta_rad[3];
    double force_n[3];        ///< of the motors on the effector at the end of the last tick
    int16_t motor_counts[3];  ///< acted during the last tick
    int16_t queued_counts[PAL_FALCON_DELAY_MAX + 1][3];  ///< [0] came last; [i] was newest i ticks ago
    uint8_t homing, leds;                                ///< as last asked for; leds: 2 green, 4 blue, 8 red
    uint8_t homed;          ///< bit i: arm i has found its reference; all three: 7
    uint8_t buttons;        ///< grip, 4 bits; for the caller to press
    uint32_t silent_ticks;  ///< since the last good packet
    uint8_t rx[16];
    uint8_t n_rx;
    bool has_reply;            ///< a good packet came that has not been answered
    int32_t offset_counts[3];  ///< what each counter is off by; zero once its arm is homed
    int16_t frozen_counts[3];
    uint8_t frozen;  ///< bit i: encoder i tells frozen_counts[i]
    uint8_t spare;   ///< byte 14 of the last request, minus 'A'
} pal_falcon_sim;

/// False when the start is outside the workspace or a parameter makes no sense.
bool pal_falcon_sim_init(pal_falcon_sim* sim, const pal_falcon_sim_config* config);
/// Bytes from the host, any number, any content: resynchronises on '<', takes whole packets, ignores the
/// rest. Motor words saturate at PAL_FALCON_MOTOR_MAX.
void pal_falcon_sim_receive(pal_falcon_sim* sim, const uint8_t* bytes, size_t n_bytes);
/// Takes the reply to the last whole packet: the encoders as they read now. False when there is none.
bool pal_falcon_sim_reply(pal_falcon_sim* sim, uint8_t reply[16]);
/// The firmware starts anew or is gone: no motor acts, nothing is homed, each counter is off by
/// `offset_counts`. The mechanics move on.
void pal_falcon_sim_restart(pal_falcon_sim* sim, const int16_t offset_counts[3]);
/// Bit i of `axes`: encoder i stands still at what it reads now; the others read truly (again).
void pal_falcon_sim_freeze(pal_falcon_sim* sim, uint8_t axes);
/// What a reply would tell now.
void pal_falcon_sim_read(const pal_falcon_sim* sim, int16_t encoder_counts[3]);
/// True when the watchdog has switched the motors off.
bool pal_falcon_sim_watchdog(const pal_falcon_sim* sim);
/// 1 ms of mechanics, `push` may be NULL. `push(context, position, velocity, force)` gives the hand's force
/// at each sub-step.
typedef void (*pal_falcon_push)(const void* context, const double position_m[3],
                                const double velocity_m_per_s[3], double force_n[3]);
/// The extra mass (a hand's) moves with the effector but weighs nothing. The effector never leaves the
/// workspace.
void pal_falcon_sim_advance(pal_falcon_sim* sim, pal_falcon_push push, const void* context,
                            double extra_mass_kg);

/// Truth, for tests and error analysis. Device frame. False, output untouched, outside the workspace: an arm
/// beyond -25..+90 degrees, or no solution. Force of motor words at a position, through the true Jacobian.
bool pal_falcon_sim_motor_force(const pal_falcon_sim_config* config, const double at_m[3],
                                const int16_t motor_counts[3], double force_n[3]);
/// The same of a Falcon, scale 1: arm angles.
bool pal_falcon_sim_theta(const double at_m[3], double theta_rad[3]);
/// Rows: d theta_i / d (x, y, z), rad/m.
bool pal_falcon_sim_jacobian(const double at_m[3], double jacobian[9]);
/// The encoder reading at a position after homing.
bool pal_falcon_sim_counts(const double at_m[3], int16_t counts[3]);

#ifdef __cplusplus
}
#endif
