/// The shared segment in which host and loop meet: a header that is checked on attach, one line of words that
/// each side owns, the table ring and the state ring. No I/O here: the caller maps the memory.
#pragma once
#include <assert.h>
#include <stdalign.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/err.h"
#include "common/state_ring.h"
#include "common/table_ring.h"
#ifdef __cplusplus
extern "C" {
#endif

enum {
    PAL_LINK_MAGIC = 0x4B4E494C,  // "LINK"
    PAL_LINK_ENDIAN = 0x01020304,
    PAL_LINK_ABI = 2
};

/// Written once by the creator (magic last), read once by whoever attaches.
typedef struct pal_link_header {
    alignas(64) uint32_t magic;
    uint32_t endian, abi, n_bytes;
    uint32_t table_bytes, tick_bytes, n_slots, n_ticks;
    uint32_t nonce;  ///< differs from run to run
    uint32_t reserved[7];
} pal_link_header;

static_assert(offsetof(pal_link_header, magic) == 0, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_header, endian) == 4, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_header, abi) == 8, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_header, n_bytes) == 12, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_header, table_bytes) == 16, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_header, tick_bytes) == 20, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_header, n_slots) == 24, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_header, n_ticks) == 28, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_header, nonce) == 32, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_header, reserved) == 36, "PROTOCOL.md 1");
static_assert(sizeof(pal_link_header) == 64, "PROTOCOL.md 1");

/// Words the host writes and the loop reads.
typedef struct pal_link_host {
    alignas(64) uint32_t pid;
    uint32_t heartbeat;  ///< changes at least every 100 ms while the host lives
    uint32_t enable;     ///< forces on; 0 pauses
    uint32_t estop;      ///< any value but 0 latches the stop
    uint32_t stop;       ///< the loop shall end in an orderly way
    uint32_t reserved[11];
} pal_link_host;

static_assert(offsetof(pal_link_host, pid) == 0, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_host, heartbeat) == 4, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_host, enable) == 8, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_host, estop) == 12, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_host, stop) == 16, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_host, reserved) == 20, "PROTOCOL.md 1");
static_assert(sizeof(pal_link_host) == 64, "PROTOCOL.md 1");

/// What the operating system granted the loop for real time. Bits of pal_link_loop.realtime and
/// realtime_refused; a step that was not asked for is in neither.
typedef enum pal_realtime {
    PAL_REALTIME_MEMORY_LOCKED = 1 << 0,  ///< mlockall: no page of the process is ever fetched again
    PAL_REALTIME_STACK_TOUCHED = 1 << 1,  ///< the stack's pages were there before the first tick
    PAL_REALTIME_TIMER_SLACK = 1 << 2,    ///< wake-ups may be late by 1 ns on purpose, not by 50 us
    PAL_REALTIME_CPU = 1 << 3,            ///< pinned to the processor that was asked for
    PAL_REALTIME_CPU_LATENCY = 1 << 4,    ///< /dev/cpu_dma_latency holds the processors out of deep sleep
    PAL_REALTIME_FIFO = 1 << 5,           ///< SCHED_FIFO
    PAL_REALTIME_DEADLINE = 1 << 6        ///< SCHED_DEADLINE
} pal_realtime;

/// Words the loop writes and the host reads.
typedef struct pal_link_loop {
    alignas(64) uint32_t pid;
    uint32_t heartbeat;   ///< the tick
    uint32_t ended;       ///< 1 after the loop sent its last zero force
    uint32_t end_reason;  ///< the PAL_FAULT_* bit that ended it; 0: it was asked to
    uint32_t n_bad_tables;
    uint32_t realtime;          ///< PAL_REALTIME_* that the system granted
    uint32_t realtime_refused;  ///< PAL_REALTIME_* that it refused
    uint32_t n_minor_faults;    ///< page faults of the tick's thread since the first tick, no disk access
    uint32_t n_major_faults;    ///< the same, with a disk access
    uint32_t n_preempted;       ///< times that the tick's thread lost its processor against its will
    uint32_t reserved[6];
} pal_link_loop;

static_assert(offsetof(pal_link_loop, pid) == 0, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_loop, heartbeat) == 4, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_loop, ended) == 8, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_loop, end_reason) == 12, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_loop, n_bad_tables) == 16, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_loop, realtime) == 20, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_loop, realtime_refused) == 24, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_loop, n_minor_faults) == 28, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_loop, n_major_faults) == 32, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_loop, n_preempted) == 36, "PROTOCOL.md 1");
static_assert(offsetof(pal_link_loop, reserved) == 40, "PROTOCOL.md 1");
static_assert(sizeof(pal_link_loop) == 64, "PROTOCOL.md 1");

typedef struct pal_link {
    pal_link_header header;
    pal_link_host host;
    pal_link_loop loop;
    pal_table_ring tables;
    pal_state_ring ticks;
} pal_link;

static_assert(offsetof(pal_link, header) == 0, "PROTOCOL.md 1");
static_assert(offsetof(pal_link, host) == 64, "PROTOCOL.md 1");
static_assert(offsetof(pal_link, loop) == 128, "PROTOCOL.md 1");
static_assert(offsetof(pal_link, tables) == 192, "PROTOCOL.md 1");
static_assert(offsetof(pal_link, ticks) == 216576, "PROTOCOL.md 1");
static_assert(sizeof(pal_link) == 1265280, "PROTOCOL.md 1");

/// Prepares `n_bytes` >= sizeof(pal_link) of memory. Afterwards pal_link_check passes.
void pal_link_init(pal_link* link, uint32_t nonce);
/// Whether `n_bytes` at `link` are a segment of this layout.
pal_err pal_link_check(const pal_link* link, size_t n_bytes);
/// Words that cross the processes: acquire load, release store.
uint32_t pal_link_load(const uint32_t* word);
void pal_link_store(uint32_t* word, uint32_t value);

#ifdef __cplusplus
}
#endif
