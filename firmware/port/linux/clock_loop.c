#include "firmware/port/linux/clock_loop.h"

#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <time.h>

static const uint64_t NS_PER_S = 1000000000U;

uint64_t pal_clock_now_ns(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * NS_PER_S + (uint64_t)now.tv_nsec;
}

static bool granted(bool ok, const char* what, int why) {
    if (!ok) fprintf(stderr, "palpate-loop: no %s (%s); carrying on without it\n", what, strerror(why));
    return ok;
}

bool pal_clock_loop_prepare(int fifo_priority) {
    bool all = granted(mlockall(MCL_CURRENT | MCL_FUTURE) == 0, "locked memory", errno);
    all = granted(prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL) == 0, "timer slack of 1 ns", errno) && all;
    const struct sched_param priority = {.sched_priority = fifo_priority};
    const int why = pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority);
    return granted(why == 0, "real-time priority (SCHED_FIFO)", why) && all;
}

void pal_clock_loop_start(pal_clock_loop* clock, uint64_t period_ns) {
    *clock = (pal_clock_loop){.period_ns = period_ns, .next_ns = pal_clock_now_ns() + period_ns};
}

void pal_clock_loop_advance(pal_clock_loop* clock, uint64_t now_ns) {
    clock->next_ns += clock->period_ns;
    if (now_ns < clock->next_ns) return;
    const uint64_t n_passed = (now_ns - clock->next_ns) / clock->period_ns + 1U;
    clock->n_missed += (uint32_t)n_passed;
    clock->next_ns += n_passed * clock->period_ns;
}

uint64_t pal_clock_loop_wait(pal_clock_loop* clock) {
    const struct timespec until = {.tv_sec = (time_t)(clock->next_ns / NS_PER_S),
                                   .tv_nsec = (long)(clock->next_ns % NS_PER_S)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL) == EINTR) {
    }
    const uint64_t now_ns = pal_clock_now_ns();
    pal_clock_loop_advance(clock, now_ns);
    return now_ns;
}
