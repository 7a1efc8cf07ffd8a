/// Novint Falcon without I/O: the caller moves bytes and tells the time; the same object serves libusb, a
/// microcontroller's USB host and a simulated device. C11, no heap, no libm but sqrt, no globals. One thread
/// at a time per device. Frame: x right, y up, z out of the device towards the user, metres, origin at the
/// base plate; forces are those on the hand.
///
/// The port, in full:
///     pal_usb_step s = pal_falcon_next(&f, now_us());
///     CONTROL: a vendor request 0x40 s.request s.value s.index; WRITE: bulk OUT of s.bytes; then call next
///     again. A transfer that failed: pal_falcon_transfer_failed(&f, device_is_gone, now_us()).
///     IDLE: wait for a bulk IN packet, s.wake_us at most; hand it to pal_falcon_feed; call next again.
/// An IN transfer may be posted all the time: any packet may be fed at any time. With PAL_USB_IDLE a port
/// that reads synchronously polls with a time-out of wake_us.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "firmware/core/delta.h"
#include "firmware/falcon/boot.h"
#include "firmware/falcon/exchange.h"
#include "firmware/falcon/failure.h"
#include "firmware/falcon/force.h"
#include "firmware/falcon/ftdi.h"
#include "firmware/falcon/homing.h"
#include "firmware/falcon/packet.h"
#include "firmware/falcon/pose.h"
#include "firmware/falcon/trace.h"
#ifdef __cplusplus
extern "C" {
#endif

typedef enum pal_falcon_state {
    PAL_FALCON_CLOSED = 0,  ///< never started, or stopped: nothing is sent any more
    PAL_FALCON_BOOTING,
    PAL_FALCON_HOMING,  ///< exchanging, zero force, until all three arms are homed
    PAL_FALCON_READY,   ///< forces
    PAL_FALCON_STOPPING,
    PAL_FALCON_FAULT  ///< for good, no force; pal_falcon_words says what to do, pal_falcon_init starts over
} pal_falcon_state;

/// What happened; sense.faults has those of the last exchange, sense.faults_seen all since the start. The
/// first five are PAL_FORCE_*.
enum {
    PAL_FALCON_NOT_FINITE = PAL_FORCE_NOT_FINITE,  ///< a force or limit was NaN or infinite: zero instead
    PAL_FALCON_WORKSPACE = PAL_FORCE_WORKSPACE,    ///< no position from these encoders: zero force
    PAL_FALCON_CLAMPED = PAL_FORCE_CLAMPED,
    PAL_FALCON_SATURATED = PAL_FORCE_SATURATED,
    PAL_FALCON_WARM = PAL_FORCE_WARM,
    PAL_FALCON_TIMEOUT = 1 << 5,      ///< a request had no reply: zero force, start ramp
    PAL_FALCON_UNASKED = 1 << 6,      ///< a reply too many: purged
    PAL_FALCON_JUMP = PAL_POSE_JUMP,  ///< an encoder moved further than an arm can: zero force, start ramp
    PAL_FALCON_HOME_LOST = 1 << 8,    ///< homed flags went while the homing bit is on: back to HOMING
    PAL_FALCON_DRIVE_STALE = 1 << 9,  ///< the caller gave no force for drive_ttl_us: zero force, start ramp
    PAL_FALCON_LINE = 1 << 10         ///< the bridge reported one of PAL_FTDI_LINE_ERRORS
};

typedef struct pal_falcon_config {
    const pal_delta* delta;  ///< geometry and gain; borrowed for good
    pal_boot_config boot;
    pal_exchange_config exchange;
    pal_force_config force;
    uint32_t n_silent_max;    ///< time-outs in a row that make PAL_FAIL_SILENT
    uint32_t n_stop_packets;  ///< zero-force requests at the end, 3 or more
    uint32_t drive_ttl_us;    ///< a force older than this is dropped; 0: never
    uint32_t button_hold_us;  ///< debounce
    pal_pose_config pose;
    bool needs_homing;        ///< false: READY at the first reply, encoders taken as they are
    bool keep_homing_bit;     ///< true: the bit stays on after homing, and lost flags are noticed
    pal_falcon_trace* trace;  ///< NULL: none
} pal_falcon_config;

/// NF1 geometry, 1 kHz, 20 ms for a reply, 8 N. Set boot.image, boot.n_image_bytes or boot.reload.
pal_falcon_config pal_falcon_config_default(void);

/// One device. The caller owns the memory and reads it by the functions below only.
typedef struct pal_falcon {
    pal_falcon_config config;
    pal_falcon_state state;
    pal_falcon_failure failure;
    pal_falcon_stage failed_stage;  ///< where it was when it failed for good
    pal_boot boot;
    pal_exchange exchange;
    pal_homing homing;
    pal_grip grip;
    pal_pose pose;
    pal_force force;
    uint64_t now_us, request_us, reply_us, drive_us;
    float wanted_n[3], wanted_limit_n, applied_n[3];
    int16_t wanted_counts[3], encoder_counts[3];
    bool wants_counts;  ///< wanted_counts is meant, not wanted_n
    bool driven;        ///< there is a force that may be used
    bool hold_zero;     ///< until the next reply
    bool asked_homing;  ///< in the request that is out
    uint8_t wanted_leds, homed_flags;
    uint32_t n_stop_sent;
    uint32_t faults, pending_faults, faults_seen;
    uint32_t traced;  ///< stage and attempt of the last PAL_TRACE_STAGE
} pal_falcon;

/// Why a device cannot be started. 0 is well.
typedef enum pal_falcon_refusal {
    PAL_FALCON_OK = 0,
    PAL_FALCON_REFUSE_CONFIG = -1,  ///< a number out of its range
    PAL_FALCON_REFUSE_NO_IMAGE = -2,
    PAL_FALCON_REFUSE_IMAGE = -3  ///< the boot container is broken: image.h says where
} pal_falcon_refusal;
const char* pal_falcon_refusal_words(pal_falcon_refusal refusal);

/// Every setting in its range, the image whole. Part of pal_falcon_init.
pal_falcon_refusal pal_falcon_config_check(const pal_falcon_config* config);

/// Checks `config` and the image, block by block, before a byte is sent, and prepares to boot. Also starts
/// over after a fault. On a refusal the state is CLOSED.
pal_falcon_refusal pal_falcon_init(pal_falcon* f, const pal_falcon_config* config);
/// What the port does next. Call it when the last step is done, after every feed, and after wake_us at the
/// latest. `now_us` never goes back. Bounded, never blocks.
pal_usb_step pal_falcon_next(pal_falcon* f, uint64_t now_us);
/// Hands over what one bulk IN transfer brought, status bytes included; any bytes and any length are safe.
void pal_falcon_feed(pal_falcon* f, const uint8_t* transfer, size_t n_bytes, uint64_t now_us);
/// The last step's transfer, or a read, failed. `gone`: the device is no longer there.
void pal_falcon_transfer_failed(pal_falcon* f, bool gone, uint64_t now_us);

/// Force for the coming exchanges, until the next call or drive_ttl_us; clamped by vector to `limit_n` (at
/// most config.force.force_max_n), zero unless READY. NaN counts as zero and as a fault. `leds`: PAL_WIRE_*
/// bits; 0 leaves the choice to the driver: red until homed, then blue.
void pal_falcon_drive(pal_falcon* f, const float force_n[3], float limit_n, uint8_t leds);
/// The same with motor words, for a loop that computes them itself. Ramp, saturation and thermal limit hold.
void pal_falcon_drive_counts(pal_falcon* f, const int16_t motor_counts[3], uint8_t leds);
/// Ends: n_stop_packets requests of zero force, then CLOSED. During a boot at once.
/// After PAL_FAIL_SILENT the same requests go out by themselves.
void pal_falcon_stop(pal_falcon* f);

/// True when nothing more will be sent: the port may close.
bool pal_falcon_done(const pal_falcon* f);

typedef struct pal_falcon_sense {
    float position_m[3];        ///< valid when has_position
    float velocity_m_per_s[3];  ///< the same, filtered; 0 at the first position
    float force_n[3];           ///< what the last request's motor words stand for; 0 with drive_counts
    int16_t encoder_counts[3];  ///< as they came
    int16_t motor_counts[3];    ///< of the last request
    uint8_t buttons;            ///< debounced, bits as pal_wire_reply
    uint8_t homed;              ///< flags as they came, 3 bits
    bool has_position;          ///< homed, and the encoders make sense
    uint64_t time_us;           ///< when the last reply came
    uint32_t n_exchanges;       ///< replies so far: changes when there is something new
    uint32_t n_timeouts;        ///< requests without a reply
    uint32_t n_unasked;         ///< replies without a request
    uint32_t n_skipped_bytes;   ///< bytes that belonged to no reply
    uint32_t faults;            ///< PAL_FALCON_* of the last exchange
    uint32_t faults_seen;       ///< and all since the start
} pal_falcon_sense;

/// Latest complete exchange. Returns the state.
pal_falcon_state pal_falcon_read(const pal_falcon* f, pal_falcon_sense* out);

typedef struct pal_falcon_status {
    pal_falcon_stage stage;      ///< present one; FAILED in a fault
    pal_falcon_stage at_stage;   ///< in a fault the stage in which it happened, else `stage`
    pal_falcon_failure failure;  ///< last one: of the fault, or of the attempt before this one
    uint32_t attempt, n_attempts;
    uint32_t baud;           ///< upload rate of this attempt, real
    uint32_t n_image_bytes;  ///< progress: echoed of image
    uint32_t n_echoed_bytes;
    uint32_t failed_byte;  ///< from 0, for PAL_FAIL_ECHO_*
} pal_falcon_status;
void pal_falcon_status_read(const pal_falcon* f, pal_falcon_status* out);

/// Stage or fault, a sentence for a person: what happens, what to do. Static text, never NULL.
const char* pal_falcon_words(const pal_falcon* f);
/// The same with its numbers ("byte 310 of 8492, attempt 2 of 6 at 142857 baud"). Always ends in 0; returns
/// the length written without it, < n_bytes. Nothing for n_bytes 0.
size_t pal_falcon_describe(const pal_falcon* f, char* out, size_t n_bytes);
/// sizeof(pal_falcon), for callers in other languages.
size_t pal_falcon_size_bytes(void);

#ifdef __cplusplus
}
#endif
