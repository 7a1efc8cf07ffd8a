#include "firmware/core/step.h"

#include <string.h>

#include "common/frame.h"
#include "firmware/core/blend.h"
#include "firmware/core/drive.h"
#include "firmware/core/ladder.h"
#include "firmware/core/track.h"

enum { LED_GREEN = 2, LED_BLUE = 4, LED_RED = 8 };

// No position, or none that may be used.
static const uint32_t NO_POSITION = PAL_FAULT_NOT_FINITE | PAL_FAULT_WORKSPACE;

pal_loop_config pal_loop_config_default(void) {
    pal_loop_config config = {
        .centre_m = {(float)PAL_WORKSPACE_CENTRE_X_M, (float)PAL_WORKSPACE_CENTRE_Y_M,
                     (float)PAL_WORKSPACE_CENTRE_Z_M},
        .force_max_n = 8.0F,
        .left_damping_n_s_per_m = 2.0F,
        .ramp_ticks = 1000,
        .fade_ticks = 16,
        .stale_ticks = 100,
        .drop_ticks = 500,
        .drop_fade_ticks = 50,
        .late_fade_ticks = 5,
        .late_stop_ticks = 20,
        .release_ticks = 200,
    };
    config.delta = &PAL_DELTA_NF1;  // apart: a constant that holds an address is data that the loader writes
    return config;
}

bool pal_loop_fading(const pal_loop_config* config, const pal_loop* loop) {
    return loop->before_id != 0 && loop->fade_tick < config->fade_ticks;
}

// The last good one where there is none now.
static void workspace_position(const pal_loop_config* config, const pal_loop* loop, float at_m[3]) {
    for (int c = 0; c < 3; ++c) at_m[c] = loop->tracked ? loop->position_m[c] - config->centre_m[c] : 0.0F;
}

// Position and table force of a fresh sample. Returns its faults.
static uint32_t feel(const pal_loop_config* config, pal_loop* loop, const pal_sense* sense,
                     const pal_loop_tables* tables, uint32_t n_ticks) {
    loop->touch = loop->homed ? loop->touch : (pal_touch){.inside = false};
    if (!loop->homed) return 0;
    uint32_t faults = pal_track(config, loop, sense->encoder_counts, n_ticks);
    if (faults != 0 || loop->table_id == 0) {
        loop->touch = (pal_touch){.inside = false};
        return faults;
    }
    float at_m[3];
    workspace_position(config, loop, at_m);
    return pal_blend_touch(config, loop, tables, at_m);
}

// What the loop asks for: the tables' share and damping on a fresh sample, otherwise the held force's share.
static void ask(const pal_loop_config* config, const pal_loop* loop, uint32_t faults, float allowed,
                float gain, float force_n[3]) {
    const bool late = (faults & PAL_FAULT_LATE) != 0;
    const float share = late ? pal_ladder_late_gain(config, loop->late_ticks) : gain;
    const float damping =
        late ? 0.0F : allowed * config->left_damping_n_s_per_m * pal_ladder_damping(config, loop, faults);
    const bool off = !(allowed > 0.0F) || (faults & NO_POSITION) != 0 || !loop->has_position;
    for (int c = 0; c < 3; ++c) {
        const float source_n = late ? loop->held_force_n[c] : loop->touch.force_n[c];
        force_n[c] = off ? 0.0F : share * source_n - damping * loop->velocity_m_per_s[c];
    }
}

static uint8_t leds(uint32_t state) {
    if (state == PAL_STATE_RAMP || state == PAL_STATE_ENABLED) return LED_BLUE;
    return state == PAL_STATE_PAUSED ? LED_GREEN : LED_RED;
}

// All but the caller's fields: clock, missed periods, stamps, truth, hand.
static void write_record(const pal_loop_config* config, const pal_loop* loop, const pal_sense* sense,
                         const pal_drive* drive, uint32_t faults, float gain, pal_tick* record) {
    const bool has_table = loop->table_id != 0;
    record->tick = loop->tick;
    record->faults = faults;
    record->state = loop->state;
    record->stop = loop->stop;
    record->table_id = loop->table_id;
    record->before_id = loop->before_id;
    record->table_age_ticks = has_table ? loop->tick - loop->table_taken_tick : 0;
    record->fade_weight = has_table ? pal_blend_weight(config, loop) : 0.0F;
    record->gain = gain;
    record->buttons = sense->buttons;
    record->homed = sense->homed;
    memcpy(record->encoder_counts, sense->encoder_counts, sizeof record->encoder_counts);
    memcpy(record->motor_counts, drive->motor_counts, sizeof record->motor_counts);
    workspace_position(config, loop, record->position_m);
    memcpy(record->velocity_m_per_s, loop->velocity_m_per_s, sizeof record->velocity_m_per_s);
    memcpy(record->force_n, loop->commanded_n, sizeof record->force_n);
    memcpy(record->table_force_n, loop->touch.force_n, sizeof record->table_force_n);
    record->depth_m = loop->touch.depth_m;
    record->k_n_per_m = loop->touch.depth_m > 0.0F ? loop->touch.k_n_per_m : 0.0F;
    record->potential_j = loop->touch.potential_j;
    record->fade_work_j = loop->fade_work_j;
    record->hand_work_j = loop->hand_work_j;
}

uint32_t pal_loop_step(const pal_loop_config* config, pal_loop* loop, const pal_sense* sense,
                       const pal_loop_tables* tables, pal_drive* drive, pal_tick* record) {
    pal_ladder_skip(config, loop, sense->n_missed);
    const uint32_t n_ticks = loop->late_ticks < UINT32_MAX ? loop->late_ticks + 1U : UINT32_MAX;
    uint32_t faults = pal_ladder_sense(config, loop, sense);
    faults |= pal_blend_notice(config, loop, tables);
    if (sense->fresh != 0) faults |= feel(config, loop, sense, tables, n_ticks);
    const float allowed = pal_ladder_gain(config, loop, sense->enable != 0, faults);
    pal_ladder_note_cut(config, loop, faults);
    const uint32_t age_ticks = loop->tick - loop->table_taken_tick;
    float gain = allowed * (loop->table_id != 0 ? pal_blend_age_gain(config, age_ticks) : 0.0F);
    if (sense->fresh == 0) gain *= pal_ladder_late_gain(config, loop->late_ticks);

    float force_n[3];
    ask(config, loop, faults, allowed, gain, force_n);
    memset(drive, 0, sizeof *drive);
    faults |= pal_drive_force(config, loop, force_n, drive->motor_counts);
    if ((faults & NO_POSITION) != 0) loop->cut = true;
    drive->homing = loop->homed ? 0 : 1;
    drive->leds = leds(loop->state);
    memcpy(loop->commanded_n, force_n, sizeof loop->commanded_n);
    if (sense->fresh != 0 || !(allowed > 0.0F))
        memcpy(loop->held_force_n, force_n, sizeof loop->held_force_n);

    write_record(config, loop, sense, drive, faults, gain, record);
    loop->tick += 1U;
    return faults;
}
