#include "sim/stand/stand.h"

#include <stdlib.h>
#include <string.h>

#include "firmware/core/intake.h"
#include "firmware/core/lookup.h"
#include "firmware/core/step.h"
#include "firmware/falcon/wire.h"

enum { ALL_HOMED = 7, SETTLE_TICKS_MAX = 64 };
static const uint64_t TICK_NS = 1000000U;

struct pal_stand {
    pal_loop_config loop_config;
    pal_loop loop;
    pal_intake intake;
    pal_sense sense;
    pal_falcon_sim falcon;
    pal_hand hand;
    pal_link* link;
};

static pal_loop_config loop_config_of(const pal_stand_config* config) {
    pal_loop_config loop_config = pal_loop_config_default();
    loop_config.force_max_n = config->force_max_n;
    loop_config.ramp_ticks = config->ramp_ticks;
    return loop_config;
}

/// One packet to the device and, when `advance` says so, 1 ms of its life; then its reply becomes the next
/// sense.
static void exchange(pal_stand* stand, const pal_drive* drive, bool advance) {
    uint8_t packet[PAL_WIRE_BYTES];
    pal_wire_encode(drive, packet);
    pal_falcon_sim_receive(&stand->falcon, packet, sizeof packet);
    if (advance) {
        pal_hand_advance(&stand->hand, stand->falcon.homed == ALL_HOMED, stand->falcon.position_m);
        pal_falcon_sim_advance(&stand->falcon, pal_hand_push, &stand->hand, stand->hand.config.mass_kg);
    }
    stand->sense.fresh = 0;
    if (pal_falcon_sim_reply(&stand->falcon, packet) && pal_wire_decode(packet, &stand->sense)) {
        stand->sense.fresh = 1;
    }
}

pal_stand* pal_stand_new(const pal_stand_config* config, pal_link* link) {
    pal_stand* stand = calloc(1, sizeof *stand);
    if (!stand) return NULL;
    stand->loop_config = loop_config_of(config);
    stand->link = link;
    stand->intake.ring = &link->tables;
    stand->intake.limits = pal_table_limits_default();
    if (!pal_falcon_sim_init(&stand->falcon, &config->falcon)) {
        free(stand);
        return NULL;
    }
    pal_hand_init(&stand->hand, &config->hand);
    const pal_drive idle = {{0, 0, 0}, 0, 0};
    exchange(stand, &idle, false);  // so that the first tick has a sample
    return stand;
}

void pal_stand_free(pal_stand* stand) {
    free(stand);
}

/// One slice of a new table's check a tick. A table of the usual size, published before this tick, is checked
/// and used in it.
static const pal_loop_tables* tables_now(pal_stand* stand) {
    const bool fading = pal_loop_fading(&stand->loop_config, &stand->loop);
    const pal_loop_tables* tables = pal_intake_poll(&stand->intake, fading);
    if (pal_intake_check_slice(&stand->intake, PAL_INTAKE_SLICE_WORDS))
        tables = pal_intake_poll(&stand->intake, fading);
    return tables;
}

static void add_truth(const pal_stand* stand, pal_tick* record) {
    const float* centre_m = stand->loop_config.centre_m;
    double force_n[3] = {0.0, 0.0, 0.0};
    const bool valid = pal_falcon_sim_motor_force(&stand->falcon.config, stand->falcon.position_m,
                                                  record->motor_counts, force_n);
    record->truth_valid = valid ? 1 : 0;
    for (int i = 0; i < 3; ++i) {
        record->truth_position_m[i] = (float)(stand->falcon.position_m[i] - (double)centre_m[i]);
        record->truth_force_n[i] = (float)force_n[i];
        record->hand_target_m[i] = (float)(stand->hand.target_m[i] - (double)centre_m[i]);
    }
    record->path_tick = stand->hand.path_tick;
}

void pal_stand_tick(pal_stand* stand, pal_tick* record) {
    memset(record, 0, sizeof *record);
    const pal_loop_tables* tables = tables_now(stand);
    stand->sense.enable = pal_link_load(&stand->link->host.enable) != 0;
    stand->sense.estop = pal_link_load(&stand->link->host.estop) != 0;
    pal_drive drive;
    (void)pal_loop_step(&stand->loop_config, &stand->loop, &stand->sense, tables, &drive, record);
    record->t_ns = (uint64_t)record->tick * TICK_NS;
    exchange(stand, &drive, true);
    add_truth(stand, record);
    pal_state_ring_push(&stand->link->ticks, record);
    pal_link_store(&stand->link->loop.heartbeat, record->tick);
    pal_link_store(&stand->link->loop.n_bad_tables, tables->n_bad);
}

void pal_stand_table_force(const pal_table* table, const float at_m[3], float force_n[3]) {
    pal_touch touch;
    pal_table_touch(table, at_m, &touch);
    memcpy(force_n, touch.force_n, sizeof touch.force_n);
}

/// The loop itself, held at one place until its start ramp is over.
bool pal_stand_static_force(const pal_stand_config* config, const pal_table* table, const double at_m[3],
                            double force_n[3]) {
    pal_loop_config loop_config = loop_config_of(config);
    loop_config.ramp_ticks = 1;
    loop_config.fade_ticks = 1;
    pal_loop loop;
    memset(&loop, 0, sizeof loop);
    pal_sense sense = {.homed = ALL_HOMED, .fresh = 1, .enable = 1};
    double device_m[3];
    for (int i = 0; i < 3; ++i) device_m[i] = at_m[i] + (double)loop_config.centre_m[i];
    if (!pal_falcon_sim_counts(device_m, sense.encoder_counts)) return false;
    const pal_loop_tables tables = {table, NULL, 0};
    pal_drive drive;
    pal_tick record;
    for (int n = 0; n < SETTLE_TICKS_MAX; ++n) {
        (void)pal_loop_step(&loop_config, &loop, &sense, &tables, &drive, &record);
        if (record.state == PAL_STATE_ENABLED && record.gain >= 1.0F && record.fade_weight >= 1.0F) break;
    }
    return pal_falcon_sim_motor_force(&config->falcon, device_m, drive.motor_counts, force_n);
}
