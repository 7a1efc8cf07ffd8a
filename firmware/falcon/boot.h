/// Booting a Falcon: from the bridge as the last session left it to a DSP that runs our image at 1.5 Mbaud.
/// A state machine without I/O or clock: every wait is bounded by the time the caller tells.
/// docs/PROTOCOL.md 4.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "firmware/falcon/failure.h"
#include "firmware/falcon/ftdi.h"
#ifdef __cplusplus
extern "C" {
#endif

enum { PAL_BOOT_BAUDS_MAX = 4, PAL_BOOT_CHUNK_BYTES = PAL_FTDI_PAYLOAD_BYTES };

typedef enum pal_reload {
    PAL_RELOAD_ALWAYS = 0,     ///< load the image, whatever runs
    PAL_RELOAD_IF_SILENT = 1,  ///< one probe packet first; no answer: load the image
    PAL_RELOAD_NEVER = 2       ///< one probe packet; no answer: PAL_FAIL_NO_FIRMWARE
} pal_reload;

typedef struct pal_boot_config {
    const uint8_t* image;  ///< borrowed until the first reply; NULL only with PAL_RELOAD_NEVER
    size_t n_image_bytes;
    pal_reload reload;
    uint32_t n_attempts;                 ///< whole boots, each from the PIC on; at least 1
    uint32_t bauds[PAL_BOOT_BAUDS_MAX];  ///< upload rate of attempt 1, 2, ...; then over again
    uint32_t n_bauds;                    ///< 1 to 4
    uint32_t dtr_low_us;                 ///< DTR is held low this long before it goes high
    uint32_t ask_wait_us;                ///< for an answer to one question to the PIC
    uint32_t n_asks;                     ///< questions per attempt
    uint32_t autobaud_wait_us;           ///< for the echo of 'A'
    uint32_t echo_wait_us;               ///< for the echo of one chunk
    uint32_t first_wait_us;              ///< for a reply to one zero-force request after the upload
    uint32_t n_first;                    ///< such requests per attempt
    uint32_t probe_wait_us;              ///< for a reply to the one probe packet
    uint8_t boot_latency_ms;             ///< of the bridge while booting, 1 to 255
    uint8_t run_latency_ms;              ///< and at run time: 2 with event_char, 1 without
    bool event_char;  ///< at run time the bridge sends what it has on '>', so no reply waits for the timer,
                      ///< and a status packet never takes a reply's frame; untested on hardware
} pal_boot_config;

/// Reload always, 6 attempts at 142857, 142857, 115385, 57554 baud in turn; no image. Worst case to the last
/// failure: 6 x (10 ms + 25 x 100 ms) = 15 s without a power supply.
pal_boot_config pal_boot_config_default(void);

/// Where a boot is. Written by boot.c only.
typedef struct pal_boot {
    pal_boot_config config;
    pal_falcon_stage stage;
    pal_falcon_failure failure;     ///< of the last attempt that failed
    pal_falcon_stage failed_stage;  ///< in which it failed
    uint32_t attempt;               ///< 1 for the first
    bool probing;                   ///< the one packet before, or instead of, an upload
    uint32_t at;                    ///< next control request of the stage's list
    uint32_t n_asked;
    size_t n_sent_bytes;    ///< of the image
    size_t n_echoed_bytes;  ///< of the image
    size_t failed_byte;     ///< of the image, for PAL_FAIL_ECHO_*
    uint32_t match;         ///< bytes of the awaited answer seen in a row
    bool arming;            ///< a write was handed out; its wait starts at the next call
    bool waiting;           ///< deadline_us is valid
    uint64_t deadline_us;
} pal_boot;

/// Starts over. `config` must have passed pal_falcon_config_check.
void pal_boot_start(pal_boot* boot, const pal_boot_config* config);
/// Next step until stage is FIRST_REPLY or FAILED; IDLE then.
pal_usb_step pal_boot_next(pal_boot* boot, uint64_t now_us);
/// Bytes from the device, without the bridge's status bytes.
void pal_boot_feed(pal_boot* boot, const uint8_t* bytes, size_t n_bytes);
/// This attempt failed: the next one from the PIC on, or FAILED when it was the last.
void pal_boot_fail(pal_boot* boot, pal_falcon_failure failure);
/// Upload rate of the present attempt, as asked for.
uint32_t pal_boot_baud(const pal_boot* boot);

#ifdef __cplusplus
}
#endif
