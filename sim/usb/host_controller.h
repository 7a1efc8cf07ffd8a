/// Host controller with one full-speed device: a queue of transfers (URBs) for each endpoint, and the rule by
/// which they meet the device. No I/O, no heap, no clock: the caller tells the time in microseconds and owns
/// the URBs. Results depend on the times of submit and cancel alone, never on how often advance is called.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

enum {
    PAL_HOST_PACKET_BYTES = 64,
    PAL_HOST_FRAME_US = 1000,
    PAL_HOST_TOKEN_US = 30,  ///< assumed: so often an idle bus asks an IN endpoint again that had nothing
    PAL_HOST_PACKETS_PER_FRAME_MAX = 19
};

/// How a URB ended: 0 or a negative errno value of Linux, as usbfs and USB/IP hand it on.
enum {
    PAL_HOST_OK = 0,
    PAL_HOST_CANCELLED = -2,      ///< ENOENT
    PAL_HOST_STALLED = -32,       ///< EPIPE: the device refused
    PAL_HOST_OVERFLOW = -75,      ///< EOVERFLOW: the device sent more than was asked for
    PAL_HOST_GONE = -108,         ///< ESHUTDOWN: unplugged
    PAL_HOST_PENDING = -115,      ///< EINPROGRESS: still queued
    PAL_HOST_SHORT = -121,        ///< EREMOTEIO: fewer bytes than wanted where that is an error
    PAL_HOST_NO_ENDPOINT = -1000  ///< of submit only: neither 0, 0x81 nor 0x02
};

/// What a device may answer instead of a number of bytes.
enum { PAL_HOST_DEVICE_STALLS = -1, PAL_HOST_DEVICE_GONE = -2 };

/// The device as the wire sees it. Times never decrease.
typedef struct pal_host_device {
    void* context;
    void (*advance)(void* context, uint64_t now_us);
    /// When an IN that gets nothing now would get something; UINT64_MAX: only after a write.
    uint64_t (*next_us)(const void* context);
    int (*control)(void* context, const uint8_t setup[8], uint8_t* data, size_t n_bytes);
    int (*out)(void* context, const uint8_t* bytes, size_t n_bytes);  ///< how many were taken; 0: not now
    int (*in)(void* context, uint8_t packet[PAL_HOST_PACKET_BYTES]);  ///< bytes of one packet; 0: not now
    bool (*present)(const void* context);
} pal_host_device;

typedef enum pal_host_timing {
    PAL_HOST_IMMEDIATE,  ///< a transfer meets the device at once
    /// ... from the next 1 ms frame on, so many packets per frame and endpoint. IN tokens go out at multiples
    /// of PAL_HOST_TOKEN_US: against these the device's 1 ms latency timer drifts, as against a real
    /// controller.
    PAL_HOST_FRAMES
} pal_host_timing;

/// One transfer. The caller fills in the first block and keeps it alive until it is reaped.
typedef struct pal_urb {
    uint8_t endpoint;  ///< 0x00 control, 0x81 IN, 0x02 OUT
    uint8_t setup[8];  ///< of a control transfer
    uint8_t* data;
    uint32_t n_bytes;
    bool short_is_error;  ///< fewer bytes than n_bytes end in PAL_HOST_SHORT
    uint64_t tag;         ///< the caller's
    void* owner;          ///< the caller's
    uint64_t id;          ///< the watcher's

    int32_t status;   ///< PAL_HOST_*
    uint32_t n_done;  ///< bytes moved, also when it failed
    uint64_t frame;   ///< in which it was submitted
    struct pal_urb* next;
} pal_urb;

typedef struct pal_host_queue {
    pal_urb* first;
    pal_urb* last;
    uint32_t n_served;  ///< packets in the present frame
} pal_host_queue;

/// Sees each URB twice: queued, with status PAL_HOST_PENDING, and ended.
typedef void (*pal_host_watcher)(void* context, pal_urb* urb, uint64_t now_us);

typedef struct pal_host {
    pal_host_device device;
    pal_host_timing timing;
    uint32_t packets_per_frame;
    uint64_t now_us;
    uint64_t out_retry_us;  ///< an OUT that the device had no room for is not tried before
    bool fresh;             ///< something was submitted since the device was last looked at
    pal_host_queue control, in, out, done;
    pal_host_watcher watcher;
    void* watcher_context;
} pal_host;

/// `packets_per_frame` counts per endpoint, 1..19; 1 is what was measured with a Falcon (docs/PROTOCOL.md 4).
void pal_host_init(pal_host* host, const pal_host_device* device, pal_host_timing timing,
                   uint32_t packets_per_frame);
/// Who sees every URB from now on; NULL: nobody.
void pal_host_watch(pal_host* host, pal_host_watcher watcher, void* context);
/// Queues `urb`. PAL_HOST_OK, PAL_HOST_GONE or PAL_HOST_NO_ENDPOINT; then the URB stays the caller's.
int pal_host_submit(pal_host* host, pal_urb* urb, uint64_t now_us);
/// Ends a queued URB with PAL_HOST_CANCELLED; it is then reaped as any other. False when it has ended
/// already.
bool pal_host_cancel(pal_host* host, pal_urb* urb);
/// The queued or ended, not yet reaped URB with this owner and tag; NULL when there is none.
pal_urb* pal_host_find(const pal_host* host, const void* owner, uint64_t tag);
/// Ends all URBs of `owner` (NULL: all) with `status`.
void pal_host_end(pal_host* host, const void* owner, int32_t status);
/// Everything up to now. A device that is gone ends all URBs with PAL_HOST_GONE.
void pal_host_advance(pal_host* host, uint64_t now_us);
/// When advance has something to do next; UINT64_MAX: only after a submit.
uint64_t pal_host_next_us(const pal_host* host);
/// The URB that ended first and was not reaped yet; NULL when there is none.
pal_urb* pal_host_reap(pal_host* host);

#ifdef __cplusplus
}
#endif
