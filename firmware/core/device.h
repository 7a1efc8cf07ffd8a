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

/// One tick: collect the reply to the previous request, run pal_loop_step, send the next request.
typedef struct pal_device {
    void* context;
    pal_device_news (*collect)(void* context, uint8_t reply[16]);
    /// PAL_DEVICE_FRESH when it was handed over, NONE when the device takes no more now, GONE.
    pal_device_news (*send)(void* context, const uint8_t request[16]);
} pal_device;

#ifdef __cplusplus
}
#endif
