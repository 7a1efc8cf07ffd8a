/// The safety ladder of DESIGN §7: lateness, latched stops, states, the start ramp and what is left of the
/// force.
#pragma once
#include "firmware/core/step.h"
#ifdef __cplusplus
extern "C" {
#endif

/// First of a tick: `n_missed` periods passed without one. They count as late ticks: tables are older by
/// them, and after five the force comes back with the ramp, after twenty the stop is latched.
void pal_ladder_skip(const pal_loop_config* config, pal_loop* loop, uint32_t n_missed);
/// Lateness, homing and the latched stops of this tick. Returns PAL_FAULT_LATE and the stop.
uint32_t pal_ladder_sense(const pal_loop_config* config, pal_loop* loop, const pal_sense* sense);
/// Share of the held force after `late_ticks` ticks without a sample: 1, then a line to 0 at late_stop_ticks.
float pal_ladder_late_gain(const pal_loop_config* config, uint32_t late_ticks);
/// Settles state and ramp. `faults` of this tick so far. Returns the share of forces that the state allows.
float pal_ladder_gain(const pal_loop_config* config, pal_loop* loop, bool enable, uint32_t faults);
/// Counts ticks without a table force and remembers when force was taken away.
void pal_ladder_note_cut(const pal_loop_config* config, pal_loop* loop, uint32_t faults);
/// Share of the damping that runs while a table is stale, left or missing; 0 when all is well.
float pal_ladder_damping(const pal_loop_config* config, const pal_loop* loop, uint32_t faults);

#ifdef __cplusplus
}
#endif
