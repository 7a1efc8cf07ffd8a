/// What a thread asks of Linux before it ticks every millisecond. Each step may be refused; the loop then
/// runs without it, says so once, and says what would grant it.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/link.h"
#ifdef __cplusplus
extern "C" {
#endif

typedef enum pal_policy {
    PAL_POLICY_FIFO = 0,      ///< SCHED_FIFO: before all ordinary threads of its processor
    PAL_POLICY_DEADLINE = 1,  ///< SCHED_DEADLINE: 0.2 ms of each 1 ms promised, and not more than that
    PAL_POLICY_OTHER = 2      ///< as any program
} pal_policy;

enum {
    PAL_REALTIME_PRIORITY = 80,
    PAL_REALTIME_ANY_CPU = -1,
    PAL_REALTIME_STACK_BYTES = 256 * 1024,  ///< touched before the first tick; also that of threads to come
    PAL_REALTIME_WORDS_BYTES = 160
};

typedef struct pal_realtime_choice {
    pal_policy policy;
    int priority;      ///< of SCHED_FIFO, 1 to 99
    int cpu;           ///< PAL_REALTIME_ANY_CPU: not pinned
    bool lock_memory;  ///< false: pages may be fetched in a tick
} pal_realtime_choice;

typedef struct pal_realtime_grants {
    uint32_t granted, refused;  ///< bits of pal_realtime
    int latency_file;           ///< held open while it counts; -1: none
} pal_realtime_grants;

/// First in main, before any thread: memory given back to the heap stays in the process, and threads to come
/// have small stacks, as every stack is locked whole.
void pal_realtime_prepare_process(void);
/// False when `choice` names a processor that is not there or may not be used; `why` is a sentence.
bool pal_realtime_possible(const pal_realtime_choice* choice, char why[PAL_REALTIME_WORDS_BYTES]);
/// All steps for the calling thread, in order: memory, processors out of deep sleep, timer slack, processor,
/// policy, stack. What is refused is said on stderr, a line each. Threads that shall not inherit it exist
/// already.
void pal_realtime_begin(const pal_realtime_choice* choice, pal_realtime_grants* grants);
/// Lets the processors sleep again.
void pal_realtime_end(pal_realtime_grants* grants);

#ifdef __cplusplus
}
#endif
