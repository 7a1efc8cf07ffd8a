/// What may go wrong with the simulated Falcon, when, for how long; and its text form, one fault a line:
///
///     unplug at_s=2 for_s=0.1
///     corrupt at_s=1.5 for_s=0.2 p=0.01 dir=in
///     split at_s=3 byte=14
///     slow-host at_s=2 for_s=0.05 every_s=1
///
/// `#` begins a comment. A fault begins at `at_s` (default 0: at once) and ends `for_s` later, or after it
/// has struck `n` times. Without for_s it strikes once, or `n` times. A slow-host with every_s comes back,
/// each time for for_s.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

typedef enum pal_usb_fault_kind {
    PAL_USB_FAULT_DROP,   ///< bytes are lost on the serial line: dir, p
    PAL_USB_FAULT_DELAY,  ///< a USB packet comes by_s late: dir, p
    PAL_USB_FAULT_SPLIT,  ///< an IN packet ends after `byte` bytes of payload, the rest comes gap_s later: p
    PAL_USB_FAULT_DUPLICATE,  ///< a USB packet comes twice: dir, p
    PAL_USB_FAULT_CORRUPT,    ///< bytes change on the serial line: dir, p
    PAL_USB_FAULT_STALL,      ///< an endpoint halts (ep) until CLEAR_FEATURE, and again while for_s lasts
    PAL_USB_FAULT_UNPLUG,     ///< the USB plug is out for for_s
    PAL_USB_FAULT_POWER_OUT,  ///< the supply of PIC, DSP and motors is out for for_s; the bridge lives from
                              ///< USB
    PAL_USB_FAULT_BOOT_FAIL,  ///< the boot fails at `stage` (pal_boot_stage of loader.h), 5 and 6 at `byte`
    PAL_USB_FAULT_FREEZE,     ///< the encoder of `axis` (0: all) stands still for for_s
    PAL_USB_FAULT_JUMP,       ///< the counter of `axis` (0: all) jumps by `counts`
    PAL_USB_FAULT_BABBLE,     ///< `length` bytes that nobody asked for, every every_s
    /// For for_s no bulk token reaches the device, as from a host too busy to send any: IN and OUT wait, also
    /// at a halted endpoint. The device's own time goes on: timers, buffers, watchdog. Control transfers are
    /// answered as ever: in this model they take no time.
    PAL_USB_FAULT_SLOW_HOST,
    PAL_USB_FAULT_KINDS
} pal_usb_fault_kind;

typedef enum pal_usb_fault_dir {
    PAL_USB_FAULT_IN = 1,   ///< device to host
    PAL_USB_FAULT_OUT = 2,  ///< host to device
    PAL_USB_FAULT_BOTH = 3
} pal_usb_fault_dir;

typedef enum pal_usb_fault_endpoint {
    PAL_USB_FAULT_EP_IN = 1,
    PAL_USB_FAULT_EP_OUT = 2,
    PAL_USB_FAULT_EP_CONTROL = 4
} pal_usb_fault_endpoint;

/// Start from pal_usb_fault_of(kind): it fills in what is usual.
typedef struct pal_usb_fault {
    pal_usb_fault_kind kind;
    uint64_t at_us;        ///< since the device's start_us
    uint64_t for_us;       ///< 0: until it has struck `n` times
    uint32_t n;            ///< strikes at most; 0: one when for_us is 0, else any number
    uint8_t dir;           ///< pal_usb_fault_dir bits
    uint8_t endpoints;     ///< pal_usb_fault_endpoint bits
    uint8_t axis;          ///< 1..3; 0: all
    uint8_t stage;         ///< pal_boot_stage
    uint32_t per_million;  ///< probability of a strike; text: p=0..1
    uint32_t byte;         ///< split: 1..61; boot-fail: byte of the container, from 0
    uint32_t length;       ///< bytes of one babble, 1..64
    int32_t counts;        ///< jump
    uint64_t by_us;        ///< delay
    uint64_t gap_us;       ///< split; 0: the rest is ready at once
    uint64_t every_us;  ///< babble, at least 1; slow-host: from one beginning to the next, more than for_us;
                        ///< 0: once
} pal_usb_fault;

enum { PAL_USB_FAULTS_MAX = 64 };

pal_usb_fault pal_usb_fault_of(pal_usb_fault_kind kind);
/// The word of the text form: "boot-fail".
const char* pal_usb_fault_name(pal_usb_fault_kind kind);
/// NULL when `fault` makes sense; else what is wrong and what would be right.
const char* pal_usb_fault_problem(const pal_usb_fault* fault);

typedef struct pal_usb_fault_error {
    uint32_t line;      ///< from 1
    char message[192];  ///< "line 3: for_s=x: write seconds, 0 to 1000000, ...": what is wrong, what would be
                        ///< right
} pal_usb_fault_error;

/// Reads `n_bytes` of text. Returns the number of faults written to `faults` (at most `n_max`), or -1 with
/// *error.
int pal_usb_faults_parse(const char* text, size_t n_bytes, pal_usb_fault* faults, size_t n_max,
                         pal_usb_fault_error* error);

#ifdef __cplusplus
}
#endif
