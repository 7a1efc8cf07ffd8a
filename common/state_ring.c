#include "common/state_ring.h"

#include <string.h>

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
    const uint32_t n = __atomic_load_n(&ring->done, __ATOMIC_RELAXED);
    uint32_t* slot = ring->word[n & MASK];
    __atomic_store_n(&ring->begun, n + 1U, __ATOMIC_RELAXED);
    // Release on each word, no fence: who sees a new word also sees `begun`. ThreadSanitizer knows no fences.
    for (int i = 0; i < PAL_TICK_WORDS; ++i) __atomic_store_n(&slot[i], word[i], __ATOMIC_RELEASE);
    __atomic_store_n(&ring->done, n + 1U, __ATOMIC_RELEASE);
}

static void drop_to(pal_state_reader* reader, uint32_t next) {
    reader->n_dropped += next - reader->next;
    reader->next = next;
}

bool pal_state_ring_read(const pal_state_ring* ring, pal_state_reader* reader, pal_tick* tick) {
    uint32_t word[PAL_TICK_WORDS];
    for (int t = 0; t < READ_TRIES; ++t) {
        const uint32_t done = __atomic_load_n(&ring->done, __ATOMIC_ACQUIRE);
        if (done == reader->next) return false;
        if (done - reader->next > PAL_STATE_RING_TICKS) drop_to(reader, done - PAL_STATE_RING_TICKS);
        const uint32_t* slot = ring->word[reader->next & MASK];
        for (int i = 0; i < PAL_TICK_WORDS; ++i) word[i] = __atomic_load_n(&slot[i], __ATOMIC_ACQUIRE);
        const uint32_t begun = __atomic_load_n(&ring->begun, __ATOMIC_RELAXED);
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
    const uint32_t n = __atomic_load_n(&ring->done, __ATOMIC_ACQUIRE) - reader->next;
    return n < PAL_STATE_RING_TICKS ? n : PAL_STATE_RING_TICKS;
}
