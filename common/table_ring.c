#include "common/table_ring.h"

#include <string.h>

// Layout of the state word; see the header.
enum {
    PREVIOUS_SHIFT = 0,
    CURRENT_SHIFT = 2,
    READY_SHIFT = 4,
    BACK_SHIFT = 6,
    COUNT_SHIFT = 9,
    TAKE_TRIES = 3
};
static const uint32_t DIRTY = 1U << 8;

static uint32_t field(uint32_t state, int shift) {
    return (state >> shift) & 3U;
}

static uint32_t pack(uint32_t previous, uint32_t current, uint32_t ready, uint32_t back) {
    return previous << PREVIOUS_SHIFT | current << CURRENT_SHIFT | ready << READY_SHIFT | back << BACK_SHIFT;
}

static uint32_t load(const pal_table_ring* ring) {
    return __atomic_load_n(&ring->state, __ATOMIC_ACQUIRE);
}

// Release gives the slots that change hands with all that was written or read in them; acquire receives.
static bool swap(pal_table_ring* ring, uint32_t* seen, uint32_t next) {
    return __atomic_compare_exchange_n(&ring->state, seen, next, false, __ATOMIC_ACQ_REL, __ATOMIC_ACQUIRE);
}

void pal_table_ring_init(pal_table_ring* ring) {
    memset(ring, 0, sizeof *ring);
    __atomic_store_n(&ring->state, pack(0, 1, 2, 3), __ATOMIC_RELEASE);
}

pal_table* pal_table_ring_back(pal_table_ring* ring) {
    return &ring->slot[field(load(ring), BACK_SHIFT)].table;
}

void pal_table_ring_publish(pal_table_ring* ring) {
    uint32_t seen = load(ring);
    uint32_t next = 0;
    do {
        const uint32_t count = (seen >> COUNT_SHIFT) + 1U;
        next = pack(field(seen, PREVIOUS_SHIFT), field(seen, CURRENT_SHIFT), field(seen, BACK_SHIFT),
                    field(seen, READY_SHIFT)) |
               DIRTY | count << COUNT_SHIFT;
    } while (!swap(ring, &seen, next));
}

static bool advance(pal_table_ring* ring, bool keep_previous) {
    uint32_t seen = load(ring);
    for (int i = 0; i < TAKE_TRIES; ++i) {
        if ((seen & DIRTY) == 0) return false;
        const uint32_t previous = field(seen, PREVIOUS_SHIFT);
        const uint32_t current = field(seen, CURRENT_SHIFT);
        const uint32_t count = seen >> COUNT_SHIFT << COUNT_SHIFT;
        const uint32_t next = pack(keep_previous ? previous : current, field(seen, READY_SHIFT),
                                   keep_previous ? current : previous, field(seen, BACK_SHIFT)) |
                              count;
        if (swap(ring, &seen, next)) return true;
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
    return &ring->slot[field(load(ring), CURRENT_SHIFT)].table;
}

const pal_table* pal_table_ring_previous(const pal_table_ring* ring) {
    return &ring->slot[field(load(ring), PREVIOUS_SHIFT)].table;
}
