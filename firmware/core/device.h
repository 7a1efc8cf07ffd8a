/// A device port: how the tick's packets reach a Falcon, real or simulated. Neither call ever waits.
#pragma once
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

typedef enum pal_device_news {
    PAL_DEVICE_NONE = 0,   ///< nothing came since the last call
    PAL_DEVICE_FRESH = 1,  ///< the newest whole reply is in `reply`
    PAL_DEVICE_GONE = 2    ///< the other end is closed; it will not come back
} pal_device_news;

/// When packets passed the device's wire, CLOCK_MONOTONIC in ns. 0: not yet.
typedef struct pal_device_times {
    uint64_t reply_ns;  ///< the last piece of the reply that collect gave last had come
    uint64_t sent_ns;   ///< the request that send took last was handed to the system
    uint64_t done_ns;   ///< the newest request whose end is known was out
} pal_device_times;

/// One tick: collect the reply to the previous request, run pal_loop_step, send the next request.
typedef struct pal_device {
    void* context;
    pal_device_news (*collect)(void* context, uint8_t reply[16]);
    /// PAL_DEVICE_FRESH when it was handed over, NONE when the device takes no more now, GONE.
    pal_device_news (*send)(void* context, const uint8_t request[16]);
    /// NULL: packets pass in the very call, which is then all there is to know.
    void (*times)(void* context, pal_device_times* times);
} pal_device;

#ifdef __cplusplus
}
#endif
