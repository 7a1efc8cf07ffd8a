#include "firmware/core/intake.h"

static uint32_t load(const pal_intake* intake) {
    return __atomic_load_n(&intake->state, __ATOMIC_ACQUIRE);
}

static void store(pal_intake* intake, pal_intake_state state) {
    __atomic_store_n(&intake->state, (uint32_t)state, __ATOMIC_RELEASE);
}

// The ring's current table is the checked one; the ring's previous is the one that was in use.
static void promote(pal_intake* intake) {
    intake->tables.before = intake->tables.now;
    intake->tables.now = pal_table_ring_current(intake->ring);
    intake->refused = false;
}

const pal_loop_tables* pal_intake_poll(pal_intake* intake, bool fading) {
    const uint32_t state = load(intake);
    if (state == PAL_INTAKE_GOOD) {
        promote(intake);
        store(intake, PAL_INTAKE_IDLE);
    } else if (state == PAL_INTAKE_BAD) {
        intake->tables.n_bad += 1U;
        intake->refused = true;  // it sits in the ring's current slot and goes back with the next one
        store(intake, PAL_INTAKE_IDLE);
    } else if (state == PAL_INTAKE_IDLE && !fading) {
        // After a refusal the table in use is the ring's previous one and must stay there.
        const bool taken =
            intake->refused ? pal_table_ring_replace(intake->ring) : pal_table_ring_take(intake->ring);
        if (taken) {
            intake->tables.before = NULL;
            store(intake, PAL_INTAKE_PENDING);
        }
    }
    return &intake->tables;
}

bool pal_intake_check(pal_intake* intake) {
    if (load(intake) != PAL_INTAKE_PENDING) return false;
    const pal_table* table = pal_table_ring_current(intake->ring);
    pal_err err = pal_table_check(table, &intake->limits);
    if (err == PAL_OK && intake->tables.now != NULL && table->id <= intake->tables.now->id)
        err = PAL_ERR_RANGE;
    if (err != PAL_OK) intake->last_err = (uint32_t)-err;
    store(intake, err == PAL_OK ? PAL_INTAKE_GOOD : PAL_INTAKE_BAD);
    return true;
}
