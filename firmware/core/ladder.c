#include "firmware/core/ladder.h"

#include "firmware/core/blend.h"

enum { ALL_HOMED = 7 };

// No table force at all in such a tick.
static const uint32_t NO_FORCE =
    PAL_FAULT_NOT_FINITE | PAL_FAULT_WORKSPACE | PAL_FAULT_TABLE_MISSING | PAL_FAULT_TABLE_LEFT;

static void count(uint32_t* ticks) {
    if (*ticks < UINT32_MAX) *ticks += 1U;
}

// An operator's stop and a dead host outrank a lost device, which may release itself; among the two the first
// stays.
static void latch(pal_loop* loop, uint32_t fault) {
    if (loop->stop == 0 || loop->stop == PAL_FAULT_DEVICE_LOST) loop->stop = fault;
}

void pal_ladder_skip(const pal_loop_config* config, pal_loop* loop, uint32_t n_missed) {
    if (n_missed == 0) return;
    const uint32_t old_ticks = config->drop_ticks + config->drop_fade_ticks;  // no table can be older
    loop->table_taken_tick -= n_missed < old_ticks ? n_missed : old_ticks;
    loop->good_ticks = 0;
    loop->late_ticks = n_missed < UINT32_MAX - loop->late_ticks ? loop->late_ticks + n_missed : UINT32_MAX;
    if (loop->late_ticks >= config->late_stop_ticks && loop->stop == 0) loop->stop = PAL_FAULT_DEVICE_LOST;
    if (loop->late_ticks >= config->late_fade_ticks) {
        loop->cut = true;
        pal_blend_end_fade(config, loop);
    }
}

uint32_t pal_ladder_sense(const pal_loop_config* config, pal_loop* loop, const pal_sense* sense) {
    const bool fresh = sense->fresh != 0;
    if (fresh) {
        loop->late_ticks = 0;
        count(&loop->good_ticks);
        if ((sense->homed & ALL_HOMED) == ALL_HOMED) loop->homed = true;
    } else {
        loop->good_ticks = 0;
        count(&loop->late_ticks);
    }
    if (loop->stop == PAL_FAULT_DEVICE_LOST && fresh) {
        const bool settled = config->release_ticks != 0 && loop->good_ticks >= config->release_ticks;
        if (settled || sense->enable == 0) loop->stop = 0;
    }
    if (loop->late_ticks >= config->late_stop_ticks && loop->stop == 0) loop->stop = PAL_FAULT_DEVICE_LOST;
    if (sense->estop != 0) latch(loop, PAL_FAULT_ESTOP);
    if (sense->host_lost != 0) latch(loop, PAL_FAULT_HOST_LOST);
    return loop->stop | (fresh ? 0U : (uint32_t)PAL_FAULT_LATE);
}

float pal_ladder_late_gain(const pal_loop_config* config, uint32_t late_ticks) {
    if (late_ticks < config->late_fade_ticks) return 1.0F;
    if (late_ticks >= config->late_stop_ticks) return 0.0F;
    const uint32_t over_ticks = late_ticks - config->late_fade_ticks + 1U;
    return 1.0F - (float)over_ticks / (float)(config->late_stop_ticks - config->late_fade_ticks + 1U);
}

static bool touches(const pal_touch* touch) {
    return touch->force_n[0] != 0.0F || touch->force_n[1] != 0.0F || touch->force_n[2] != 0.0F;
}

float pal_ladder_gain(const pal_loop_config* config, pal_loop* loop, bool enable, uint32_t faults) {
    const bool held = loop->stop != 0 || !loop->homed || !enable;
    if (held) {
        loop->state = loop->stop != 0 ? PAL_STATE_FAULT : loop->homed ? PAL_STATE_PAUSED : PAL_STATE_HOMING;
        loop->ramp_tick = 0;
        return 0.0F;
    }
    if (loop->cut && (faults & (NO_FORCE | PAL_FAULT_TABLE_DROPPED | PAL_FAULT_LATE)) == 0) {
        if (touches(&loop->touch)) loop->ramp_tick = 0;  // out of contact there is nothing to ramp
        loop->cut = false;
    }
    if (loop->ramp_tick >= config->ramp_ticks) {
        loop->state = PAL_STATE_ENABLED;
        return 1.0F;
    }
    loop->state = PAL_STATE_RAMP;
    const float gain = (float)loop->ramp_tick / (float)config->ramp_ticks;
    if ((faults & PAL_FAULT_LATE) == 0) loop->ramp_tick += 1U;
    return gain;
}

void pal_ladder_note_cut(const pal_loop_config* config, pal_loop* loop, uint32_t faults) {
    if ((faults & (PAL_FAULT_TABLE_MISSING | PAL_FAULT_TABLE_LEFT)) != 0) {
        count(&loop->empty_ticks);
    } else {
        loop->empty_ticks = 0;
    }
    if ((faults & (NO_FORCE | PAL_FAULT_TABLE_DROPPED)) != 0 || loop->late_ticks >= config->late_fade_ticks) {
        loop->cut = true;
        pal_blend_end_fade(config, loop);
    }
}

float pal_ladder_damping(const pal_loop_config* config, const pal_loop* loop, uint32_t faults) {
    if ((faults & (PAL_FAULT_NOT_FINITE | PAL_FAULT_WORKSPACE)) != 0) return 0.0F;
    if (loop->empty_ticks > 0) return pal_blend_age_gain(config, loop->empty_ticks);
    if ((faults & PAL_FAULT_TABLE_STALE) != 0) {
        return pal_blend_age_gain(config, loop->tick - loop->table_taken_tick);
    }
    return 0.0F;
}
