/// The lockstep stand: loop, wire, simulated Falcon and simulated hand, advanced together tick by tick. The
/// same objects as in real time, in one process, with no clock but the tick counter.
#pragma once
#include <stdbool.h>
#include <stdint.h>

#include "common/link.h"
#include "sim/falcon/falcon_sim.h"
#include "sim/hand/hand.h"
#ifdef __cplusplus
extern "C" {
#endif

typedef struct pal_stand_config {
    pal_falcon_sim_config falcon;
    pal_hand_config hand;
    float force_max_n;
    uint32_t ramp_ticks;
} pal_stand_config;

typedef struct pal_stand pal_stand;

/// Builds a stand on `link` (which the caller made with pal_link_init and keeps). NULL when memory or config
/// fail. `hand` paths are borrowed until pal_stand_free.
pal_stand* pal_stand_new(const pal_stand_config* config, pal_link* link);
void pal_stand_free(pal_stand* stand);
/// One tick: intake, step, packet out, 1 ms of mechanics, packet in. The record, truth included, goes to the
/// link's state ring and to *record. A new table is checked in slices of PAL_INTAKE_SLICE_WORDS, one a tick,
/// and used from the tick of the last slice on: with 27 nodes or fewer that of the first.
void pal_stand_tick(pal_stand* stand, pal_tick* record);

/// One static evaluation, for maps and error analysis: the force (N, workspace frame) that the loop's look-up
/// gives at `at_m`. No rounding.
void pal_stand_table_force(const pal_table* table, const float at_m[3], float force_n[3]);
/// The whole static path without dynamics: position -> encoder counts -> kinematics -> table -> clamp ->
/// motor words -> force by the simulator's own Jacobian at the true position. `at_m`: workspace frame. False
/// outside the workspace.
bool pal_stand_static_force(const pal_stand_config* config, const pal_table* table, const double at_m[3],
                            double force_n[3]);

#ifdef __cplusplus
}
#endif
