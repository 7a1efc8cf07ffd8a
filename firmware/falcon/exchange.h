/// One request, one reply, never two requests at once. A reply carries no number, so after a time-out or an
/// unasked reply the bridge is purged and what still comes is thrown away before the next request.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "firmware/falcon/ftdi.h"
#include "firmware/falcon/packet.h"
#ifdef __cplusplus
extern "C" {
#endif

typedef struct pal_exchange_config {
    uint32_t period_us;      ///< least time between two requests; 0: as fast as the device answers
    uint32_t reply_wait_us;  ///< after which a reply is given up
    uint32_t drain_us;       ///< after a purge, what comes within this time is thrown away
} pal_exchange_config;

typedef enum pal_exchange_phase {
    PAL_EXCHANGE_FREE = 0,  ///< the next request may go when its time has come
    PAL_EXCHANGE_SENT,      ///< handed out; the wait starts at the next call
    PAL_EXCHANGE_WAIT,      ///< for the reply
    PAL_EXCHANGE_PURGE_OUT,
    PAL_EXCHANGE_PURGE_IN,
    PAL_EXCHANGE_PURGED,  ///< the drain starts at the next call
    PAL_EXCHANGE_DRAIN
} pal_exchange_phase;

/// Written by exchange.c only. Zero-initialise.
typedef struct pal_exchange {
    pal_exchange_phase phase;
    pal_wire_reader reader;
    uint8_t packet[PAL_WIRE_BYTES];  ///< the request that is out
    uint64_t deadline_us;            ///< of WAIT and DRAIN
    uint64_t due_us;                 ///< of the next request
    uint32_t n_silent;               ///< time-outs since the last reply
    uint32_t n_requests, n_replies, n_timeouts;
    uint32_t n_unasked;  ///< whole replies that nobody waited for
} pal_exchange;

/// The step, or `*wants_request` = true: then build a request and call pal_exchange_send.
pal_usb_step pal_exchange_next(const pal_exchange_config* config, pal_exchange* x, uint64_t now_us,
                               bool* wants_request);
pal_usb_step pal_exchange_send(const pal_exchange_config* config, pal_exchange* x, uint64_t now_us,
                               const pal_wire_request* request);
/// Bytes without status bytes. True when the awaited reply is among them; of several the last one counts.
bool pal_exchange_feed(pal_exchange* x, const uint8_t* bytes, size_t n_bytes, pal_wire_reply* reply);
/// The port could not send: as a time-out.
void pal_exchange_broken(pal_exchange* x);

#ifdef __cplusplus
}
#endif
