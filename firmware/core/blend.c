#include "firmware/core/blend.h"

#include "common/atomic.h"

static const float FORCE_FINITE_N = 1.0e6F;  // anything a table says beyond this is a broken table
static const float FINITE_MAX = 3.0e38F;

static bool usable(const pal_table* table) {
    return table != NULL && pal_table_header_ok(table);
}

// Once a tick: what its writer makes of it meanwhile must not give one table two names.
static uint64_t id_of(const pal_table* table) {
    uint64_t id;
    pal_copy_once(&id, &table->id, sizeof id);
    return id;
}

static bool is_before(const pal_loop_tables* tables, uint64_t id) {
    return usable(tables->before) && id_of(tables->before) == id;
}

static uint32_t age_faults(const pal_loop_config* config, const pal_loop* loop) {
    const uint32_t age_ticks = loop->tick - loop->table_taken_tick;
    uint32_t faults = age_ticks >= config->stale_ticks ? (uint32_t)PAL_FAULT_TABLE_STALE : 0U;
    if (age_ticks >= config->drop_ticks) faults |= PAL_FAULT_TABLE_DROPPED;
    return faults;
}

uint32_t pal_blend_notice(const pal_loop_config* config, pal_loop* loop, const pal_loop_tables* tables) {
    uint32_t faults = tables->n_bad != loop->n_bad_seen ? (uint32_t)PAL_FAULT_TABLE_BAD : 0U;
    loop->n_bad_seen = tables->n_bad;
    const pal_table* now = tables->now;
    if (!usable(now)) {
        loop->table_id = 0;
        pal_blend_end_fade(config, loop);
        return faults | PAL_FAULT_TABLE_MISSING | (now != NULL ? (uint32_t)PAL_FAULT_TABLE_BAD : 0U);
    }
    const uint64_t id = id_of(now);
    if (id != loop->table_id) {
        const bool fade = config->fade_ticks > 0 && loop->table_id != 0 && is_before(tables, loop->table_id);
        if (id > loop->table_id) loop->table_taken_tick = loop->tick;
        loop->before_id = fade ? loop->table_id : 0;
        loop->fade_tick = fade ? 0 : config->fade_ticks;
        loop->before = loop->touch;
        loop->table_id = id;
    } else if (loop->before_id != 0 && !is_before(tables, loop->before_id)) {
        pal_blend_end_fade(config, loop);
    }
    return faults | age_faults(config, loop);
}

void pal_blend_end_fade(const pal_loop_config* config, pal_loop* loop) {
    loop->before_id = 0;
    loop->fade_tick = config->fade_ticks;
}

float pal_blend_weight(const pal_loop_config* config, const pal_loop* loop) {
    if (loop->before_id == 0 || loop->fade_tick >= config->fade_ticks) return 1.0F;
    const float x = (float)loop->fade_tick / (float)config->fade_ticks;
    return x * x * (3.0F - 2.0F * x);
}

float pal_blend_age_gain(const pal_loop_config* config, uint32_t age_ticks) {
    if (age_ticks < config->drop_ticks) return 1.0F;
    const uint32_t over_ticks = age_ticks - config->drop_ticks;
    if (over_ticks >= config->drop_fade_ticks) return 0.0F;
    return 1.0F - (float)over_ticks / (float)config->drop_fade_ticks;
}

static bool within(float x, float most) {
    return x >= -most && x <= most;  // false for NaN
}

static bool touch_finite(const pal_touch* touch) {
    bool ok = within(touch->potential_j, FORCE_FINITE_N) && within(touch->depth_m, FINITE_MAX) &&
              within(touch->k_n_per_m, FINITE_MAX);
    for (int c = 0; c < 3; ++c) ok = ok && within(touch->force_n[c], FORCE_FINITE_N);
    return ok;
}

// One tick of the fade. Outside the old table its last answer holds: no jump, and it fades out anyway.
static void mix(const pal_loop_config* config, pal_loop* loop, const pal_table* before, const float at_m[3]) {
    pal_touch* now = &loop->touch;
    pal_touch old;
    pal_table_touch(before, at_m, &old);
    if (old.inside && touch_finite(&old)) loop->before = old;
    old = loop->before;
    const float weight_was = pal_blend_weight(config, loop);
    loop->fade_tick += 1U;
    const float weight = pal_blend_weight(config, loop);
    loop->fade_work_j += (now->potential_j - old.potential_j) * (weight - weight_was);
    for (int c = 0; c < 3; ++c) {
        now->force_n[c] = (1.0F - weight) * old.force_n[c] + weight * now->force_n[c];
    }
    now->potential_j = (1.0F - weight) * old.potential_j + weight * now->potential_j;
    if (loop->fade_tick >= config->fade_ticks) pal_blend_end_fade(config, loop);
}

uint32_t pal_blend_touch(const pal_loop_config* config, pal_loop* loop, const pal_loop_tables* tables,
                         const float at_m[3]) {
    pal_table_touch(tables->now, at_m, &loop->touch);
    uint32_t fault = 0;
    if (!loop->touch.inside) {
        fault = PAL_FAULT_TABLE_LEFT;
    } else if (!touch_finite(&loop->touch)) {
        fault = PAL_FAULT_NOT_FINITE;
    }
    if (fault != 0) {
        loop->touch = (pal_touch){.inside = false};
        return fault;
    }
    if (loop->before_id != 0) mix(config, loop, tables->before, at_m);
    return 0;
}
