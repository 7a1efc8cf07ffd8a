/// The port of firmware/falcon/falcon.h on libusb: does what pal_falcon_next asks for by asynchronous
/// transfers, keeps bulk IN transfers posted all the time and feeds what they bring. One thread at a time.
#pragma once
#include "firmware/falcon/falcon.h"
#include "firmware/port/linux/pcap.h"
#include "firmware/port/linux/usb_link.h"

struct libusb_transfer;
#ifdef __cplusplus
extern "C" {
#endif

enum {
    PAL_USB_IN_POSTED = 4,  ///< of one packet each: a full packet does not wait for a short one after it
    PAL_USB_WAIT_MAX_US = 100000,
    PAL_USB_CLOSE_MAX_US = 1000000,  ///< for the zero forces, and again for the transfers to end
    PAL_USB_SETUP_BYTES = 8,
    PAL_USB_FDS_MAX = 8
};

/// An open port lies still in memory: its transfers point to it.
typedef struct pal_usb_falcon {
    pal_usb_link link;
    pal_falcon* falcon;  ///< borrowed
    pal_pcap* pcap;      ///< borrowed; NULL: none
    struct libusb_transfer* in[PAL_USB_IN_POSTED];
    struct libusb_transfer* step;  ///< carries out one step
    uint8_t in_bytes[PAL_USB_IN_POSTED][PAL_FTDI_PACKET_BYTES];
    uint8_t step_bytes[PAL_FTDI_PACKET_BYTES];
    bool busy;             ///< `step` is under way
    bool gone;             ///< unplugged, or all reads fail: close it
    bool closing;          ///< nothing is posted any more
    uint32_t n_under_way;  ///< transfers, reads included
    uint32_t n_bad;        ///< failed reads in a row
    uint32_t n_packets;    ///< bulk IN packets so far
    uint64_t n_submitted;
    uint64_t came_ns;  ///< the last IN packet with more than status; CLOCK_MONOTONIC, as the next two
    uint64_t sent_ns;  ///< the last bulk OUT transfer was handed to the system ...
    uint64_t done_ns;  ///< ... and the last that ended well has ended
} pal_usb_falcon;

/// CLOCK_MONOTONIC in microseconds: the time of everything here.
uint64_t pal_usb_now_us(void);

/// Opens the device and posts the reads; `falcon` is ready to boot (pal_falcon_init). On failure nothing is
/// open and `why` is a sentence.
pal_usb_problem pal_usb_falcon_open(pal_usb_falcon* port, pal_falcon* falcon, const char* serial,
                                    pal_pcap* pcap, char why[PAL_USB_WORDS_BYTES]);
/// The same on a link that is open already, which the port then owns.
pal_usb_problem pal_usb_falcon_adopt(pal_usb_falcon* port, pal_falcon* falcon, const pal_usb_link* link,
                                     pal_pcap* pcap, char why[PAL_USB_WORDS_BYTES]);

/// Takes what has ended so far and feeds it. Never waits.
void pal_usb_falcon_collect(pal_usb_falcon* port);
/// Hands out the next step if the one before is done. Never waits. Microseconds until it should be called
/// again, unless something ends before.
uint32_t pal_usb_falcon_send(pal_usb_falcon* port);
/// One turn of a thread that does nothing else: send, wait for an event or `most_us`, collect.
void pal_usb_falcon_turn(pal_usb_falcon* port, uint32_t most_us);

/// Zero forces, then takes all transfers back and closes; after an unplug at once. Bounded by twice
/// PAL_USB_CLOSE_MAX_US. A port that is not open is left alone.
void pal_usb_falcon_close(pal_usb_falcon* port);
/// The same without the zero forces: what is left of a port whose device is gone. `link` goes to the caller,
/// who closes it.
void pal_usb_falcon_abandon(pal_usb_falcon* port, pal_usb_link* link);

#ifdef __cplusplus
}
#endif
