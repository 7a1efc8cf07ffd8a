#include "common/state_ring.h"

#include <string.h>

#include "common/atomic.h"

enum {
    MASK = PAL_STATE_RING_TICKS - 1,
    READ_TRIES = 8,
    MARGIN_TICKS = 64  // how far a reader that was overtaken in mid-copy jumps clear of the writer
};
static_assert((PAL_STATE_RING_TICKS & MASK) == 0, "a power of two");

void pal_state_ring_init(pal_state_ring* ring) {
    memset(ring, 0, sizeof *ring);
}

void pal_state_ring_push(pal_state_ring* ring, const pal_tick* tick) {
    uint32_t word[PAL_TICK_WORDS];
    memcpy(word, tick, sizeof word);
    const uint32_t n = pal_atomic_load_relaxed(&ring->done);
    uint32_t* slot = ring->word[n & MASK];
    pal_atomic_store_relaxed(&ring->begun, n + 1U);
    // Release on each word, no fence: who sees a new word also sees `begun`. ThreadSanitizer knows no fences.
    for (int i = 0; i < PAL_TICK_WORDS; ++i) pal_atomic_store_release(&slot[i], word[i]);
    pal_atomic_store_release(&ring->done, n + 1U);
}

static void drop_to(pal_state_reader* reader, uint32_t next) {
    reader->n_dropped += next - reader->next;
    reader->next = next;
}

bool pal_state_ring_read(const pal_state_ring* ring, pal_state_reader* reader, pal_tick* tick) {
    uint32_t word[PAL_TICK_WORDS];
    for (int t = 0; t < READ_TRIES; ++t) {
        const uint32_t done = pal_atomic_load_acquire(&ring->done);
        if (done == reader->next) return false;
        // `begun` is stored first. Far from `done` one of them is damaged; the writer's next record mends
        // both.
        if (pal_atomic_load_relaxed(&ring->begun) - done > PAL_STATE_RING_TICKS) return false;
        if (done - reader->next > PAL_STATE_RING_TICKS) drop_to(reader, done - PAL_STATE_RING_TICKS);
        const uint32_t* slot = ring->word[reader->next & MASK];
        for (int i = 0; i < PAL_TICK_WORDS; ++i) word[i] = pal_atomic_load_acquire(&slot[i]);
        const uint32_t begun = pal_atomic_load_relaxed(&ring->begun);
        if (begun - reader->next <= PAL_STATE_RING_TICKS) {
            memcpy(tick, word, sizeof word);
            reader->next += 1U;
            return true;
        }
        drop_to(reader, begun - PAL_STATE_RING_TICKS + MARGIN_TICKS);
    }
    return false;
}

uint32_t pal_state_ring_waiting(const pal_state_ring* ring, const pal_state_reader* reader) {
    const uint32_t n = pal_atomic_load_acquire(&ring->done) - reader->next;
    return n < PAL_STATE_RING_TICKS ? n : PAL_STATE_RING_TICKS;
}
