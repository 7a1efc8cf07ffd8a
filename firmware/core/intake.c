#include "firmware/core/intake.h"

#include "common/atomic.h"

static uint32_t load(const pal_intake* intake) {
    return pal_atomic_load_acquire(&intake->state);
}

static void store(pal_intake* intake, pal_intake_state state) {
    pal_atomic_store_release(&intake->state, (uint32_t)state);
}

// What was checked is what is used, whatever the ring's word says by now.
static void promote(pal_intake* intake) {
    pal_note_read(&intake->pending_id);
    pal_note_write(&intake->now_id);
    intake->now_id = intake->pending_id;
    intake->tables.before = intake->tables.now;
    intake->tables.now = intake->pending;
    intake->refused = false;
}

static void take(pal_intake* intake) {
    // After a refusal the table in use is the ring's previous one and must stay there.
    const bool taken =
        intake->refused ? pal_table_ring_replace(intake->ring) : pal_table_ring_take(intake->ring);
    if (!taken) return;
    pal_note_write(&intake->pending);
    intake->pending = pal_table_ring_current(intake->ring);
    intake->tables.before = NULL;
    store(intake, PAL_INTAKE_PENDING);
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
        take(intake);
    }
    return &intake->tables;
}

static uint64_t id_of(const pal_table* table) {
    uint64_t id;
    pal_note_read(table);
    pal_copy_once(&id, &table->id, sizeof id);
    return id;
}

bool pal_intake_check_slice(pal_intake* intake, uint32_t n_words_max) {
    if (load(intake) != PAL_INTAKE_PENDING) return false;
    pal_note_read(&intake->pending);
    const pal_table* table = intake->pending;
    if (intake->checking.stage == 0) intake->checking_id = id_of(table);
    const uint64_t id = intake->checking_id;
    pal_err err;
    if (!pal_table_check_slice(&intake->checking, table, &intake->limits, n_words_max, &err)) return false;
    pal_note_read(&intake->now_id);
    // Unchanged: an id that a broken writer spoils meanwhile must not shut out all that come after it.
    if (err == PAL_OK && (id <= intake->now_id || id_of(table) != id)) err = PAL_ERR_RANGE;
    pal_note_write(&intake->pending_id);
    intake->pending_id = id;
    if (err != PAL_OK) intake->last_err = (uint32_t)-err;
    store(intake, err == PAL_OK ? PAL_INTAKE_GOOD : PAL_INTAKE_BAD);
    return true;
}

bool pal_intake_check(pal_intake* intake) {
    return pal_intake_check_slice(intake, UINT32_MAX);
}
