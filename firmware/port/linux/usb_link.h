/// One Falcon opened and claimed through libusb, with a libusb context of its own.
#pragma once
#include "firmware/port/linux/usb_find.h"

struct libusb_context;
struct libusb_device;
struct libusb_device_handle;
#ifdef __cplusplus
extern "C" {
#endif

typedef struct pal_usb_link {
    struct libusb_context* context;
    struct libusb_device_handle* handle;
    pal_usb_found about;
} pal_usb_link;

/// Opens the Falcon with this serial number; NULL: the first in order. A kernel driver is asked to let go and
/// gets the device back at the end. May take some milliseconds. On failure `link` is empty and `why` a
/// sentence.
pal_usb_problem pal_usb_link_open(pal_usb_link* link, const char* serial, char why[PAL_USB_WORDS_BYTES]);
/// No transfer may be under way. An empty link is left alone.
void pal_usb_link_close(pal_usb_link* link);

/// Part of pal_usb_find and pal_usb_link_open: reads what is to be said of `device`, opened or not.
void pal_usb_link_describe(struct libusb_device* device, pal_usb_found* about);
/// Part of the same: opens and claims `device`. `*handle` is NULL on failure.
pal_usb_problem pal_usb_link_claim(struct libusb_device* device, struct libusb_device_handle** handle);

#ifdef __cplusplus
}
#endif
