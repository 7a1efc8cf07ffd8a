/// Falcons on this machine's USB, in the order of their serial numbers, and whether this user may use them.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

enum {
    PAL_USB_DEVICES_MAX = 16,
    PAL_USB_TEXT_BYTES = 64,
    PAL_USB_NODE_BYTES = 32,
    PAL_USB_WORDS_BYTES = 512
};

/// Where the udev rule goes that gives users the device; the rule lies beside this file.
#define PAL_USB_RULE_FILE "/etc/udev/rules.d/60-palpate-falcon.rules"

typedef enum pal_usb_problem {
    PAL_USB_OK = 0,
    PAL_USB_NONE,    ///< no such device
    PAL_USB_DENIED,  ///< the node exists, this user may not open it
    PAL_USB_BUSY,    ///< another program has claimed it
    PAL_USB_FAILED   ///< anything else that libusb says
} pal_usb_problem;

typedef struct pal_usb_found {
    char serial[PAL_USB_TEXT_BYTES];  ///< "" when it cannot be read
    char product[PAL_USB_TEXT_BYTES];
    char node[PAL_USB_NODE_BYTES];  ///< "/dev/bus/usb/001/002"
    char user[PAL_USB_TEXT_BYTES];  ///< who has claimed it, as pal_usb_who
    uint8_t bus, address;
    uint16_t speed_mbit_per_s;  ///< 12: full speed; 0: not known
    pal_usb_problem access;
} pal_usb_found;

/// Sorted by serial, then by bus and address. How many were written; -1 with a sentence in `why` when libusb
/// cannot start. Opens and claims each for a moment.
int pal_usb_find(pal_usb_found found[PAL_USB_DEVICES_MAX], char why[PAL_USB_WORDS_BYTES]);

/// The process, among those this user may look into, that has the device node open: "name (process 4711)", or
/// "". Looks through /proc: milliseconds.
void pal_usb_who(const char* node, char user[PAL_USB_TEXT_BYTES]);

/// What `problem` with the device `about` means and what to do, one or two sentences.
void pal_usb_explain(pal_usb_problem problem, const pal_usb_found* about, char why[PAL_USB_WORDS_BYTES]);

#ifdef __cplusplus
}
#endif
