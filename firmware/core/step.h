/// The tick: what was sensed and the newest tables in, motor words out. One pure function, run alike by the
/// process palpate-loop, by the lockstep stand and on a microcontroller. No heap, clock, lock, I/O, or libm
/// but sqrt.
#pragma once
#include <stdbool.h>
#include <stdint.h>

#include "common/table.h"
#include "common/tick.h"
#include "firmware/core/delta.h"
#include "firmware/core/lookup.h"
#ifdef __cplusplus
extern "C" {
#endif

/// Fixed for the life of a loop. May be shared by several loops.
typedef struct pal_loop_config {
    const pal_delta* delta;
    float centre_m[3];             ///< the workspace frame's origin in the device frame
    float force_max_n;             ///< |force| limit, in (0, 8.9]
    float left_damping_n_s_per_m;  ///< damping while a table is stale or left
    uint32_t ramp_ticks;           ///< soft start after homing and after every stop
    uint32_t fade_ticks;           ///< ticks over which a new table replaces the old one
    uint32_t stale_ticks;          ///< age from which a table is frozen and damped (100)
    uint32_t drop_ticks;           ///< age from which its force goes to zero (500), over drop_fade_ticks
    uint32_t drop_fade_ticks;      ///< 50
    uint32_t late_fade_ticks;      ///< late ticks from which the held force fades (5)
    uint32_t late_stop_ticks;      ///< late ticks at which it is zero and latched (20)
    uint32_t release_ticks;  ///< a latched DEVICE_LOST releases itself after this many good ticks; 0: only by
                             ///< enable 0
} pal_loop_config;

/// DESIGN §7's figures, the Falcon's geometry, workspace middle at (0, 0, 0.12) m of the device frame.
/// release_ticks is 200, right for a simulated device; a real one wants 0.
pal_loop_config pal_loop_config_default(void);

/// What came from the device and the operator for this tick.
typedef struct pal_sense {
    int16_t encoder_counts[3];
    uint8_t buttons, homed;  ///< grip buttons (4 bits); one homed bit per arm (3 bits)
    uint8_t fresh;           ///< 0: no new sample came this tick; encoder_counts are then ignored
    uint8_t enable;          ///< operator: forces on
    uint8_t estop;           ///< operator: latch the stop
    uint8_t host_lost;       ///< the host process is gone: zero, latched
    uint32_t n_missed;       ///< periods that passed without a tick since the last one: each counts as late
} pal_sense;

typedef struct pal_drive {
    int16_t motor_counts[3];
    uint8_t homing;  ///< ask the device to home
    uint8_t leds;    ///< 2 green, 4 blue, 8 red
} pal_drive;

/// Tables for one tick; each NULL or a table that passed pal_table_check. While pal_loop_fading, the pair
/// stays.
typedef struct pal_loop_tables {
    const pal_table* now;     ///< newest
    const pal_table* before;  ///< the one it replaced
    uint32_t n_bad;           ///< tables refused so far
} pal_loop_tables;

/// All that changes from tick to tick. Zero-initialise; the caller owns it.
typedef struct pal_loop {
    uint32_t tick;
    uint32_t state;        ///< a pal_state
    uint32_t stop;         ///< PAL_FAULT_* that latched the stop
    uint32_t late_ticks;   ///< ticks and missed periods since the last fresh sample
    uint32_t good_ticks;   ///< fresh samples in a row
    uint32_t ramp_tick;    ///< of config ramp_ticks
    uint32_t fade_tick;    ///< of config fade_ticks
    uint32_t empty_ticks;  ///< ticks in a row without a table force (missing or left)
    uint32_t table_taken_tick;
    uint32_t n_bad_seen;
    uint64_t table_id, before_id;  ///< in use; being faded out (0: no fade)
    float position_m[3];           ///< device frame, last good
    float velocity_m_per_s[3];
    pal_touch touch;        ///< what the tables said at the last fresh sample
    pal_touch before;       ///< the same of the table that is being faded out
    float held_force_n[3];  ///< commanded at the last fresh sample
    float commanded_n[3];   ///< commanded in the last tick
    float fade_work_j, hand_work_j;
    bool has_position;  ///< position_m belongs to the last fresh sample
    bool tracked;       ///< position_m has been known at least once
    bool homed;         ///< latched: all three arms found their origin
    bool cut;           ///< the ladder took force away; back in contact the start ramp runs
} pal_loop;

/// Runs one 1 ms tick. Writes *drive and *record on every path; what each fault does to the force is DESIGN
/// §7. Returns this tick's PAL_FAULT_* bits, 0 when healthy. Bounded time, no I/O, no allocation. The
/// record's clock, truth and hand fields are left for the caller.
uint32_t pal_loop_step(const pal_loop_config* config, pal_loop* loop, const pal_sense* sense,
                       const pal_loop_tables* tables, pal_drive* drive, pal_tick* record);
/// True while a table is being faded out: no table may be taken from the ring then.
bool pal_loop_fading(const pal_loop_config* config, const pal_loop* loop);

#ifdef __cplusplus
}
#endif
