/// A periodic real-time loop on the absolute monotonic clock: the phase is kept, missed periods are skipped
/// and counted.
#pragma once
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

typedef struct pal_clock_loop {
    uint64_t period_ns;
    uint64_t next_ns;   ///< start of the next period, CLOCK_MONOTONIC
    uint32_t n_missed;  ///< periods that passed without a tick, modulo 2^32
    uint32_t late_ns;   ///< of the last waking after the start of its period; saturates
} pal_clock_loop;

uint64_t pal_clock_now_ns(void);
void pal_clock_loop_start(pal_clock_loop* clock, uint64_t period_ns);
/// Sleeps to the start of the next period; returns the time of waking.
uint64_t pal_clock_loop_wait(pal_clock_loop* clock);
/// The arithmetic of pal_clock_loop_wait, without the sleep: moves on to the first period after `now_ns`.
void pal_clock_loop_advance(pal_clock_loop* clock, uint64_t now_ns);

#ifdef __cplusplus
}
#endif
