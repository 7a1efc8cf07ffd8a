/// One run of the loop between a link and a device: what each 1 ms tick does around pal_loop_step. No clock,
/// thread or system call of its own.
#pragma once
#include <stdbool.h>
#include <stdint.h>

#include "common/link.h"
#include "firmware/core/device.h"
#include "firmware/core/intake.h"
#include "firmware/core/step.h"
#ifdef __cplusplus
extern "C" {
#endif

enum {
    PAL_SESSION_HOST_QUIET_TICKS = 500,  ///< without a host heartbeat: the host is lost
    PAL_SESSION_ZERO_TICKS = 20          ///< packets of zero force at the end
};

typedef enum pal_session_end {
    PAL_SESSION_RUNS = 0,
    PAL_SESSION_ASKED = 1,
    PAL_SESSION_HOST_LOST = 2,
    PAL_SESSION_DEVICE_GONE = 3,
    PAL_SESSION_SEGMENT_GONE = 4
} pal_session_end;

/// When a tick began. Virtual time: no lateness, nothing missed.
typedef struct pal_session_time {
    uint64_t t_ns;          ///< of waking, CLOCK_MONOTONIC
    uint32_t n_missed;      ///< periods missed since the start, modulo 2^32
    uint32_t wake_late_ns;  ///< t_ns minus the start that was asked for
} pal_session_time;

/// Zero-initialise, then pal_session_begin. Words marked so are set by other threads.
typedef struct pal_session {
    pal_loop_config config;
    pal_loop loop;
    pal_intake intake;
    pal_link* link;
    pal_device device;
    uint64_t (*now_ns)(void);  ///< for the stamps
    uint32_t host_gone;        ///< any thread: the host's process is gone
    uint32_t asked;            ///< any thread, signal handlers: end in an orderly way
    uint32_t segment_gone;     ///< any thread, signal handlers: `link` is not shared any more
    uint32_t heartbeat_seen, quiet_ticks;
    uint32_t n_missed_seen;
    uint64_t handed_ns;  ///< T4 of the last request that the device took
} pal_session;

void pal_session_begin(pal_session* session, pal_link* link, const pal_device* device,
                       const pal_loop_config* config, uint64_t (*now_ns)(void));
/// One tick: reply in, step, request out, record to the ring. Never waits, allocates nothing, and calls
/// nothing of the system but by the device. Stopped in its middle for as long as the held force would have
/// been faded, it sends zero.
pal_session_end pal_session_tick(pal_session* session, const pal_session_time* when);
/// One packet of zero force.
void pal_session_send_zero(const pal_session* session);
/// Tells the host that the last zero force is out, and why.
void pal_session_finish(const pal_session* session, pal_session_end end);

#ifdef __cplusplus
}
#endif
