#include "firmware/app/warm.h"

#include <string.h>

#include "firmware/falcon/wire.h"

enum { ALL_HOMED = 7, SWAP_TICK = PAL_WARM_TICKS / 2 };

static const float SKIN_M = 1.0e-3F;  // above the middle of the workspace
static const float STIFFNESS_N_PER_M = 100.0F;
static const float SPACING_M = 1.0e-3F;

static void make_table(pal_table* table, uint64_t id) {
    const uint32_t n_coef = (PAL_TABLE_NODES_MIN + 2U) * (PAL_TABLE_NODES_MIN + 2U);
    memset(table, 0, sizeof *table);
    table->id = id;
    table->n_nodes = PAL_TABLE_NODES_MIN;
    table->spacing_m = SPACING_M;
    table->valid_radius_m = SPACING_M;
    for (int i = 0; i < 3; ++i) table->axes[4 * i] = 1.0F;
    for (uint32_t i = 0; i < n_coef; ++i) {
        table->coef[i] = SKIN_M;
        table->coef[n_coef + i] = STIFFNESS_N_PER_M;
    }
    pal_table_seal(table);
}

// The tool in the middle of the workspace, as a device would tell it.
static bool rest_in_the_middle(const pal_loop_config* config, uint8_t packet[PAL_WIRE_BYTES]) {
    pal_drive counts = {.homing = 0};
    float theta_rad[3];
    if (!pal_delta_inverse(config->delta, config->centre_m, theta_rad)) return false;
    for (int i = 0; i < 3; ++i) {
        if (!pal_delta_counts(config->delta, theta_rad[i], &counts.motor_counts[i])) return false;
    }
    pal_wire_encode(&counts, packet);  // the numbers stand where a reply has its encoders
    return true;
}

uint32_t pal_warm_loop(const pal_loop_config* config) {
    pal_loop loop;
    pal_table first;
    pal_table second;
    uint8_t packet[PAL_WIRE_BYTES];
    uint32_t n_felt = 0;
    if (!rest_in_the_middle(config, packet)) return 0;
    memset(&loop, 0, sizeof loop);
    make_table(&first, 1);
    make_table(&second, 2);
    for (uint32_t n = 0; n < PAL_WARM_TICKS; ++n) {
        uint8_t request[PAL_WIRE_BYTES];
        pal_sense sense = {.fresh = 0};
        pal_drive drive;
        pal_tick record;
        const pal_loop_tables tables = {.now = n < SWAP_TICK ? &first : &second,
                                        .before = n < SWAP_TICK ? NULL : &first};
        (void)pal_wire_decode(packet, &sense);
        sense.homed = ALL_HOMED;
        sense.enable = 1;
        (void)pal_loop_step(config, &loop, &sense, &tables, &drive, &record);
        pal_wire_encode(&drive, request);
        if (loop.touch.force_n[2] > 0.0F) n_felt += 1U;
    }
    return n_felt;
}
