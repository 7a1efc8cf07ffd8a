/// Taking the force away from a device whose loop has died: what each 1 ms tick does. No clock, thread or
/// system call of its own.
#pragma once
#include <stdbool.h>
#include <stdint.h>

#include "firmware/app/session.h"
#ifdef __cplusplus
extern "C" {
#endif

enum { PAL_TAKEOVER_TICKS_MAX = 200 };  ///< after which a device that does not answer is given up

typedef enum pal_takeover_end {
    PAL_TAKEOVER_RUNS = 0,
    PAL_TAKEOVER_DONE = 1,     ///< the device took all packets and has answered
    PAL_TAKEOVER_HUNG_UP = 2,  ///< the other end is closed
    PAL_TAKEOVER_SILENT = 3    ///< no answer, or it takes no packets
} pal_takeover_end;

/// Zero-initialise.
typedef struct pal_takeover {
    uint32_t n_ticks;
    uint32_t n_sent;  ///< packets that the device took
    bool answered;
} pal_takeover;

/// One tick: reply in, one packet of zero force out. PAL_SESSION_ZERO_TICKS of them, and until one is
/// answered more; nothing is sent in the tick that ends it. Ends within PAL_TAKEOVER_TICKS_MAX ticks.
pal_takeover_end pal_takeover_tick(pal_takeover* takeover, const pal_device* device);

#ifdef __cplusplus
}
#endif
