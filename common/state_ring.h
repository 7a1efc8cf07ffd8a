/// Tick records from the loop to any number of readers in shared memory. The writer never waits: a reader
/// that falls behind loses the oldest records and is told how many.
#pragma once
#include <assert.h>
#include <stdalign.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/tick.h"
#ifdef __cplusplus
extern "C" {
#endif

enum {
    PAL_STATE_RING_TICKS = 4096,  ///< a power of two: four seconds
    PAL_TICK_WORDS = (int)(sizeof(pal_tick) / sizeof(uint32_t))
};

typedef struct pal_state_ring {
    alignas(64) uint32_t begun;  ///< records whose writing has begun, modulo 2^32
    alignas(64) uint32_t done;   ///< records that are complete, modulo 2^32
    alignas(64) uint32_t word[PAL_STATE_RING_TICKS][PAL_TICK_WORDS];  ///< the bytes of each pal_tick
} pal_state_ring;

static_assert(offsetof(pal_state_ring, begun) == 0, "PROTOCOL.md 1");
static_assert(offsetof(pal_state_ring, done) == 64, "PROTOCOL.md 1");
static_assert(offsetof(pal_state_ring, word) == 128, "PROTOCOL.md 1");
static_assert(sizeof(pal_state_ring) == 128 + PAL_STATE_RING_TICKS * 256, "PROTOCOL.md 1");

/// One reader's place. Zero-initialised it starts at the first record of the ring's life.
typedef struct pal_state_reader {
    uint32_t next;
    uint32_t n_dropped;  ///< records lost because this reader was slow
} pal_state_reader;

void pal_state_ring_init(pal_state_ring* ring);
/// Writer, one only: wait-free, about 60 ns.
void pal_state_ring_push(pal_state_ring* ring, const pal_tick* tick);
/// Copies the next record; false when there is none, or when `begun` and `done` cannot both be right (until
/// the next push). No data race in the C11 model: words cross as 32-bit atomics, and a copy during which the
/// writer came round is dropped and counted.
bool pal_state_ring_read(const pal_state_ring* ring, pal_state_reader* reader, pal_tick* tick);
/// Records that `reader` has not read yet.
uint32_t pal_state_ring_waiting(const pal_state_ring* ring, const pal_state_reader* reader);

#ifdef __cplusplus
}
#endif
