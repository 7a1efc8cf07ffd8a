/// A Falcon on the USB as the device of the 1 kHz loop (firmware/core/device.h). Each tick takes what came
/// and hands out one request, and never waits: what takes time - to find, open and boot a device that went
/// away - is done by a thread of its own. That thread is the watchdog too: a loop that stops ticking gets its
/// force taken away.
#pragma once
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>

#include "firmware/core/device.h"
#include "firmware/port/linux/firmware_file.h"
#include "firmware/port/linux/usb_falcon.h"
#ifdef __cplusplus
extern "C" {
#endif

enum {
    PAL_USB_DEVICE_LOOK_US = 20000,     ///< the thread looks this often
    PAL_USB_DEVICE_SILENT_US = 100000,  ///< without a tick: the thread keeps up the requests, of zero force
    PAL_USB_DEVICE_REOPEN_US = 200000   ///< between two attempts to find a lost device
};

/// Lies still while open. What follows `in_use` belongs to whoever set it.
typedef struct pal_usb_device {
    pthread_t thread;
    pal_device_times times;      ///< the tick's alone
    uint32_t stop;               ///< asks the thread to end
    uint32_t in_use;             ///< try-lock of tick and thread
    uint32_t n_lost, n_resumed;  ///< how often the device went and came back
    pal_firmware_file firmware;
    pal_falcon_config config;
    pal_falcon falcon;
    pal_usb_falcon port;
    char serial[PAL_USB_TEXT_BYTES];
    uint32_t n_taken;  ///< exchanges that collect has told of
    uint64_t tick_us;  ///< of the last send
    bool lost;         ///< the port is to be opened anew
    bool was_ready;    ///< from then on nothing is told while a device homes again
} pal_usb_device;

typedef enum pal_usb_device_open_result {
    PAL_USB_DEVICE_OPEN = 0,
    PAL_USB_DEVICE_STOPPED,      ///< `*stop` was set
    PAL_USB_DEVICE_NO_FIRMWARE,  ///< `why` has the sentence
    PAL_USB_DEVICE_FAILED        ///< likewise
} pal_usb_device_open_result;

/// Which device, and what it is. NULL everywhere is the first Novint Falcon.
typedef struct pal_usb_device_choice {
    const char* serial;      ///< NULL: the first
    const char* firmware;    ///< file; NULL: the usual places
    const pal_delta* delta;  ///< borrowed; NULL: the Novint Falcon NF1
    const float* start_m;    ///< of `delta`: where the search for the first position starts, 3
} pal_usb_device_choice;

/// Finds, opens and boots; returns when the device answers, which takes a second or so, or when all attempts
/// have failed, or soon after `*stop` is not 0. It takes motor words: the limit on a force is the loop's to
/// keep; here stay the start ramp, saturation and thermal limit.
pal_usb_device_open_result pal_usb_device_open(pal_usb_device* usb, const pal_usb_device_choice* choice,
                                               const volatile sig_atomic_t* stop, pal_device* device,
                                               char why[PAL_FIRMWARE_WORDS_BYTES]);
/// Zero forces, then closed. Bounded.
void pal_usb_device_close(pal_usb_device* usb);

#ifdef __cplusplus
}
#endif
