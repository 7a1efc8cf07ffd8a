/// Which tables are in use, how old they are, and the force that they make together while one fades into the
/// other.
#pragma once
#include "firmware/core/step.h"
#ifdef __cplusplus
extern "C" {
#endif

/// Takes note of the tables of this tick: a new one starts a fade and is young again. Every tick. Returns
/// PAL_FAULT_TABLE_MISSING, _BAD, _STALE, _DROPPED.
uint32_t pal_blend_notice(const pal_loop_config* config, pal_loop* loop, const pal_loop_tables* tables);
/// Force of the tables at the tool (workspace frame) into loop->touch; moves a running fade on by one tick
/// and books its work. Returns 0, PAL_FAULT_TABLE_LEFT or PAL_FAULT_NOT_FINITE; then the touch is zero.
/// `tables->now` is usable.
uint32_t pal_blend_touch(const pal_loop_config* config, pal_loop* loop, const pal_loop_tables* tables,
                         const float at_m[3]);
/// The new table has all the weight from now on.
void pal_blend_end_fade(const pal_loop_config* config, pal_loop* loop);
/// Weight of the new table, a smoothstep of the fade's progress.
float pal_blend_weight(const pal_loop_config* config, const pal_loop* loop);
/// Share of the force that is left at a table's age: 1, and from drop_ticks on to 0 over drop_fade_ticks.
float pal_blend_age_gain(const pal_loop_config* config, uint32_t age_ticks);

#ifdef __cplusplus
}
#endif
