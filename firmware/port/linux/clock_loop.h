/// A periodic real-time loop on the absolute monotonic clock: the phase is kept, missed periods are skipped
/// and counted.
#pragma once
#include <stdbool.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

typedef struct pal_clock_loop {
    uint64_t period_ns;
    uint64_t next_ns;   ///< start of the next period, CLOCK_MONOTONIC
    uint32_t n_missed;  ///< periods that passed without a tick
} pal_clock_loop;

uint64_t pal_clock_now_ns(void);
/// Asks for locked memory, timer slack of 1 ns and SCHED_FIFO for the calling thread. What is refused is said
/// on stderr and the loop runs without it. True when all was granted.
bool pal_clock_loop_prepare(int fifo_priority);
void pal_clock_loop_start(pal_clock_loop* clock, uint64_t period_ns);
/// Sleeps to the start of the next period; returns the time of waking.
uint64_t pal_clock_loop_wait(pal_clock_loop* clock);
/// The arithmetic of pal_clock_loop_wait, without the sleep: moves on to the first period after `now_ns`.
void pal_clock_loop_advance(pal_clock_loop* clock, uint64_t now_ns);

#ifdef __cplusplus
}
#endif
