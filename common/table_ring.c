#include "common/table_ring.h"

#include <string.h>

#include "common/atomic.h"

// Layout of the state word; see the header.
enum {
    PREVIOUS_SHIFT = 0,
    CURRENT_SHIFT = 2,
    READY_SHIFT = 4,
    BACK_SHIFT = 6,
    COUNT_SHIFT = 9,
    ALL_SLOTS = (1 << PAL_TABLE_SLOTS) - 1,
    TAKE_TRIES = 3,
    PUBLISH_TRIES = 8  // the reader takes once at most between two publications: two would do
};
static const uint32_t DIRTY = 1U << 8;

static uint32_t field(uint32_t state, int shift) {
    return (state >> shift) & 3U;
}

static uint32_t pack(uint32_t previous, uint32_t current, uint32_t ready, uint32_t back) {
    return previous << PREVIOUS_SHIFT | current << CURRENT_SHIFT | ready << READY_SHIFT | back << BACK_SHIFT;
}

// A permutation. A word that is none was written by neither side, and nobody knows any more whose a slot is.
static bool is_whole(uint32_t state) {
    return (1U << field(state, PREVIOUS_SHIFT) | 1U << field(state, CURRENT_SHIFT) |
            1U << field(state, READY_SHIFT) | 1U << field(state, BACK_SHIFT)) == ALL_SLOTS;
}

void pal_table_ring_init(pal_table_ring* ring) {
    memset(ring, 0, sizeof *ring);
    pal_atomic_store_release(&ring->state, pack(0, 1, 2, 3));
}

pal_table* pal_table_ring_back(pal_table_ring* ring) {
    const uint32_t state = pal_atomic_load_acquire(&ring->state);
    return is_whole(state) ? &ring->slot[field(state, BACK_SHIFT)].table : NULL;
}

// Each swap's release gives the slots that change hands with all that was written or read in them; its
// acquire receives.
bool pal_table_ring_publish(pal_table_ring* ring) {
    uint32_t seen = pal_atomic_load_acquire(&ring->state);
    for (int i = 0; i < PUBLISH_TRIES && is_whole(seen); ++i) {
        const uint32_t count = (seen >> COUNT_SHIFT) + 1U;
        const uint32_t next = pack(field(seen, PREVIOUS_SHIFT), field(seen, CURRENT_SHIFT),
                                   field(seen, BACK_SHIFT), field(seen, READY_SHIFT)) |
                              DIRTY | count << COUNT_SHIFT;
        if (pal_atomic_swap(&ring->state, &seen, next)) return true;
    }
    return false;
}

static bool advance(pal_table_ring* ring, bool keep_previous) {
    uint32_t seen = pal_atomic_load_acquire(&ring->state);
    for (int i = 0; i < TAKE_TRIES; ++i) {
        if ((seen & DIRTY) == 0 || !is_whole(seen)) return false;
        const uint32_t previous = field(seen, PREVIOUS_SHIFT);
        const uint32_t current = field(seen, CURRENT_SHIFT);
        const uint32_t count = seen >> COUNT_SHIFT << COUNT_SHIFT;
        const uint32_t next = pack(keep_previous ? previous : current, field(seen, READY_SHIFT),
                                   keep_previous ? current : previous, field(seen, BACK_SHIFT)) |
                              count;
        if (pal_atomic_swap(&ring->state, &seen, next)) return true;
    }
    return false;
}

bool pal_table_ring_take(pal_table_ring* ring) {
    return advance(ring, false);
}

bool pal_table_ring_replace(pal_table_ring* ring) {
    return advance(ring, true);
}

const pal_table* pal_table_ring_current(const pal_table_ring* ring) {
    return &ring->slot[field(pal_atomic_load_acquire(&ring->state), CURRENT_SHIFT)].table;
}

const pal_table* pal_table_ring_previous(const pal_table_ring* ring) {
    return &ring->slot[field(pal_atomic_load_acquire(&ring->state), PREVIOUS_SHIFT)].table;
}
