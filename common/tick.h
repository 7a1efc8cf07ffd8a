/// One record a tick: what the loop saw, which table it used, what it did. 256 bytes, fixed, no padding: the
/// state ring and the record file hold nothing else.
#pragma once
#include <assert.h>
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

typedef enum pal_state {
    PAL_STATE_DISABLED = 0,
    PAL_STATE_HOMING = 1,  ///< waiting for the device to find its origin; no force
    PAL_STATE_RAMP = 2,    ///< force grows from zero after homing or after a stop
    PAL_STATE_ENABLED = 3,
    PAL_STATE_PAUSED = 4,  ///< an operator switched the forces off
    PAL_STATE_FAULT = 5    ///< latched; see stop
} pal_state;

/// Why the force is not what the table says. Bits of pal_tick.faults.
typedef enum pal_fault {
    PAL_FAULT_NOT_FINITE = 1 << 0,     ///< a sensed value was NaN or infinite
    PAL_FAULT_WORKSPACE = 1 << 1,      ///< outside the workspace, or the kinematics have no answer there
    PAL_FAULT_TABLE_MISSING = 1 << 2,  ///< no table has come yet
    PAL_FAULT_TABLE_LEFT = 1 << 3,     ///< the tool left the table's valid radius
    PAL_FAULT_TABLE_STALE = 1 << 4,    ///< older than 100 ms: frozen and damped
    PAL_FAULT_TABLE_DROPPED = 1 << 5,  ///< older than 500 ms: force to zero
    PAL_FAULT_TABLE_BAD = 1 << 6,      ///< a table was refused by its check
    PAL_FAULT_FORCE_CLAMP = 1 << 7,    ///< |force| cut to force_max_n
    PAL_FAULT_MOTOR_CLAMP = 1 << 8,    ///< motor words scaled down together
    PAL_FAULT_LATE =
        1 << 9,  ///< no fresh sample: the last force held or faded; or the tick itself was stopped
    PAL_FAULT_DEVICE_LOST = 1 << 10,  ///< 20 ticks or missed periods without a sample: zero, latched
    PAL_FAULT_ESTOP = 1 << 11,        ///< emergency stop, latched
    PAL_FAULT_HOST_LOST = 1 << 12     ///< the host process is gone
} pal_fault;

typedef struct pal_tick {
    uint64_t t_ns;             ///< start of the tick: CLOCK_MONOTONIC, or tick * 1e6 in virtual time
    uint32_t tick;             ///< since the loop's start
    uint32_t faults;           ///< PAL_FAULT_* of this tick
    uint32_t state;            ///< a pal_state
    uint32_t stop;             ///< the PAL_FAULT_* bit that latched the stop; 0: none
    uint64_t table_id;         ///< in use; 0: none
    uint64_t before_id;        ///< table that is being faded out; 0: none
    uint32_t table_age_ticks;  ///< ticks and missed periods since a table was last taken
    float fade_weight;         ///< of table_id, 0..1; before_id has the rest
    float gain;                ///< ladder and ramp: force = gain * table force, 0..1
    uint32_t n_missed;         ///< periods missed since the start
    uint8_t buttons, homed, truth_valid, reserved_byte;
    int16_t encoder_counts[3];
    int16_t motor_counts[3];
    float position_m[3];        ///< tool centre, workspace frame
    float velocity_m_per_s[3];  ///< low-passed
    float force_n[3];           ///< commanded, after ladder and clamp, before motor rounding
    float table_force_n[3];     ///< what the tables said
    float depth_m;              ///< of the tool's lowest point below the undeformed skin; <= 0: no contact
    float k_n_per_m;            ///< linear stiffness under the tool; 0 without contact
    float potential_j;          ///< of the table(s) at the tool
    float fade_work_j;          ///< energy injected by table swaps since the start
    float hand_work_j;          ///< work done by the device on the hand since the start (commanded force)
    float reserved_j[3];
    uint64_t stamp_ns[6];       ///< T0..T5 of docs/DESIGN.md (latency); 0 in virtual time
    float truth_position_m[3];  ///< simulated device: where the tool centre really is at the end of the tick
    float truth_force_n[3];     ///< simulated device: what the motor words of this tick do at that point
    float hand_target_m[3];     ///< simulated hand: where it wants to be
    uint32_t path_tick;         ///< ticks since the hand's path began, 0 before; simulated hand only
    uint32_t wake_late_ns;      ///< t_ns minus the programmed start; saturates; 0 in virtual time
    uint32_t reserved[3];
} pal_tick;

static_assert(offsetof(pal_tick, t_ns) == 0, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, tick) == 8, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, faults) == 12, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, state) == 16, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, stop) == 20, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, table_id) == 24, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, before_id) == 32, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, table_age_ticks) == 40, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, fade_weight) == 44, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, gain) == 48, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, n_missed) == 52, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, buttons) == 56, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, homed) == 57, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, truth_valid) == 58, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, reserved_byte) == 59, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, encoder_counts) == 60, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, motor_counts) == 66, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, position_m) == 72, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, velocity_m_per_s) == 84, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, force_n) == 96, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, table_force_n) == 108, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, depth_m) == 120, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, k_n_per_m) == 124, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, potential_j) == 128, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, fade_work_j) == 132, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, hand_work_j) == 136, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, reserved_j) == 140, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, stamp_ns) == 152, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, truth_position_m) == 200, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, truth_force_n) == 212, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, hand_target_m) == 224, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, path_tick) == 236, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, wake_late_ns) == 240, "PROTOCOL.md 3");
static_assert(offsetof(pal_tick, reserved) == 244, "PROTOCOL.md 3");
static_assert(sizeof(pal_tick) == 256, "PROTOCOL.md 3");

#ifdef __cplusplus
}
#endif
