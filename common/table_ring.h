/// Hand-over of tables from one writer to one reader in shared memory: four slots, all ownership in one word
/// that is swapped by compare-and-exchange. Always the newest table, in place, without a copy; a crash of
/// either side at any instruction leaves a consistent state. Why not a seqlock or a queue: docs/DESIGN.md.
#pragma once
#include <assert.h>
#include <stdalign.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/table.h"
#ifdef __cplusplus
extern "C" {
#endif

enum { PAL_TABLE_SLOTS = 4 };

/// `state`: previous[1:0] current[3:2] ready[5:4] back[7:6] dirty[8] count[31:9]; the four are a permutation
/// of 0..3.
typedef struct pal_table_ring {
    alignas(64) uint32_t state;
    uint32_t reserved[15];
    struct {
        alignas(64) pal_table table;
    } slot[PAL_TABLE_SLOTS];
} pal_table_ring;

static_assert(offsetof(pal_table_ring, state) == 0, "PROTOCOL.md 1");
static_assert(offsetof(pal_table_ring, slot) == 64, "PROTOCOL.md 1");
static_assert(sizeof(pal_table_ring) == 64 + PAL_TABLE_SLOTS * 54080, "PROTOCOL.md 1");  // the slots' stride

/// Empty ring: no table yet. Not while another process uses it.
void pal_table_ring_init(pal_table_ring* ring);

/// Writer: the slot to fill. It stays the writer's until pal_table_ring_publish. NULL when the state word is
/// damaged (no permutation): no slot is then known to be free, and nothing can be published any more.
pal_table* pal_table_ring_back(pal_table_ring* ring);
/// Writer: makes the back slot the newest. Wait-free: tries again only when the reader swapped at the same
/// moment, which it does once at most. False when the word is damaged: nothing was published.
bool pal_table_ring_publish(pal_table_ring* ring);

/// Reader: when there is a newer table, previous <- current <- newest, and true. The old previous goes back
/// to the writer. At most three tries, then false: the tick keeps what it has; a damaged word is left alone
/// likewise, so that its tables grow old and the force goes. Call only when no fade uses previous.
bool pal_table_ring_take(pal_table_ring* ring);
/// Reader: like take, but the *current* table goes back to the writer and previous stays: for a refused
/// table.
bool pal_table_ring_replace(pal_table_ring* ring);
const pal_table* pal_table_ring_current(const pal_table_ring* ring);
const pal_table* pal_table_ring_previous(const pal_table_ring* ring);

#ifdef __cplusplus
}
#endif
