/// Front end for machines with USB in the kernel: exports the devices by USB/IP 1.1.1 (protocol 0x0111) over
/// TCP, one importer for each. `usbip attach -r HOST -b 1-1` makes it a device of that machine.
#pragma once
#include <poll.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "sim/usb/bus.h"

enum { PAL_USBIP_PEERS_MAX = 16, PAL_USBIP_FDS_MAX = 1 + PAL_USBIP_PEERS_MAX };

typedef struct pal_usbip_bytes {
    uint8_t* bytes;
    size_t n, n_room;
} pal_usbip_bytes;

typedef struct pal_usbip_peer {
    int fd;         ///< -1: none
    bool attached;  ///< it has imported `port`
    bool ends;      ///< hang up when all is written
    uint32_t port;
    size_t n_urb_bytes;  ///< of its transfers in flight
    pal_usbip_bytes in, out;
} pal_usbip_peer;

typedef struct pal_usbip {
    pal_bus* bus;  ///< borrowed
    int listener;
    uint16_t tcp_port;  ///< as bound
    pal_usbip_peer peers[PAL_USBIP_PEERS_MAX];
} pal_usbip;

/// Listens at an IPv4 address; port 0 takes a free one. False with words in `why`; then close is still due.
bool pal_usbip_open(pal_usbip* server, pal_bus* bus, const char* address, uint16_t tcp_port, char* why,
                    size_t n_why);
size_t pal_usbip_fds(const pal_usbip* server, struct pollfd fds[PAL_USBIP_FDS_MAX]);
/// Everything that can be done now, without waiting.
void pal_usbip_serve(pal_usbip* server);
void pal_usbip_close(pal_usbip* server);
/// How many importers the device of this port has, 0 or 1.
uint32_t pal_usbip_n_open(const pal_usbip* server, uint32_t port);
