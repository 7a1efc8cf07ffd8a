#include "firmware/port/linux/clock_loop.h"

#include <errno.h>
#include <time.h>

static const uint64_t NS_PER_S = 1000000000U;

uint64_t pal_clock_now_ns(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * NS_PER_S + (uint64_t)now.tv_nsec;
}

void pal_clock_loop_start(pal_clock_loop* clock, uint64_t period_ns) {
    *clock = (pal_clock_loop){.period_ns = period_ns, .next_ns = pal_clock_now_ns() + period_ns};
}

void pal_clock_loop_advance(pal_clock_loop* clock, uint64_t now_ns) {
    clock->next_ns += clock->period_ns;
    if (now_ns < clock->next_ns) return;
    const uint64_t n_passed = (now_ns - clock->next_ns) / clock->period_ns + 1U;
    clock->n_missed += n_passed < UINT32_MAX ? (uint32_t)n_passed : UINT32_MAX;
    clock->next_ns += n_passed * clock->period_ns;
}

uint64_t pal_clock_loop_wait(pal_clock_loop* clock) {
    const struct timespec until = {.tv_sec = (time_t)(clock->next_ns / NS_PER_S),
                                   .tv_nsec = (long)(clock->next_ns % NS_PER_S)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL) == EINTR) {
    }
    const uint64_t now_ns = pal_clock_now_ns();
    const uint64_t late_ns = now_ns > clock->next_ns ? now_ns - clock->next_ns : 0U;
    clock->late_ns = late_ns < UINT32_MAX ? (uint32_t)late_ns : UINT32_MAX;
    pal_clock_loop_advance(clock, now_ns);
    return now_ns;
}
