/// What passes the host controller, as a file that Wireshark reads: pcap with Linux' usbmon headers of 64
/// bytes (link type 220). A transfer is a record 'S' when it is submitted and a record 'C' when it ends.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "sim/usb/host_controller.h"
#ifdef __cplusplus
extern "C" {
#endif

enum {
    PAL_USBMON_LINK_TYPE = 220,
    PAL_USBMON_HEADER_BYTES = 64,
    PAL_USBMON_SNAP_BYTES = 65536,  ///< of one record with its header; longer data are cut
    PAL_USBMON_ROOM_BYTES = 1 << 17
};

/// Only whole records are handed to the system: the file can be read too when the process was killed.
typedef struct pal_usbmon {
    int fd;  ///< -1: none is written
    bool failed;
    int reason;  ///< errno of the first write that failed; nothing is written after it
    uint64_t last_id;
    uint64_t begin_us;  ///< since 1970, of the time 0 of the controllers
    uint64_t written_us;
    size_t n;
    uint8_t room[PAL_USBMON_ROOM_BYTES];
} pal_usbmon;

/// Begins FILE anew. A pipe whose reader lets it be full for a second ends the capture. `begin_us`:
/// microseconds since 1970 at the controllers' time 0. False: errno says why.
bool pal_usbmon_open(pal_usbmon* mon, const char* file, uint64_t begin_us);
/// One record: 'S' for an URB with status PAL_HOST_PENDING, else 'C'. The 'S' gives the URB its id. What is
/// in memory reaches the file about once a second.
void pal_usbmon_see(pal_usbmon* mon, uint8_t address, pal_urb* urb, uint64_t now_us);
/// Writes what is left. False when something could not be written: `reason`.
bool pal_usbmon_close(pal_usbmon* mon);

#ifdef __cplusplus
}
#endif
