/// What has disturbed a thread, as the kernel counts it: page faults, and how often it lost its processor.
/// Read by another thread, so that the reading does not disturb.
#pragma once
#include <stdbool.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

typedef struct pal_disturbance_counts {
    uint32_t n_minor_faults;  ///< page faults without a disk access ...
    uint32_t n_major_faults;  ///< ... and with one
    uint32_t n_preempted;     ///< switched away against its will
} pal_disturbance_counts;

typedef struct pal_disturbance {
    int stat_file, status_file;  ///< of /proc
    pal_disturbance_counts start;
} pal_disturbance;

/// Watches thread `tid` of this process from now on. False when /proc does not tell.
bool pal_disturbance_open(pal_disturbance* self, int tid);
/// Since pal_disturbance_open. False: the thread is gone.
bool pal_disturbance_read(const pal_disturbance* self, pal_disturbance_counts* counts);
void pal_disturbance_close(pal_disturbance* self);

#ifdef __cplusplus
}
#endif
