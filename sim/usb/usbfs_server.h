/// Front end for programs under the preload library: a bus folder, and a socket for each open device. Does
/// what the kernel's usbfs does: claims, queues of URBs, their end when a program closes or dies, hot-plug.
#pragma once
#include <poll.h>
#include <stdbool.h>
#include <stddef.h>

#include "sim/usb/bus.h"
#include "sim/usb/usbfs_client.h"
#include "sim/usb/usbfs_tree.h"

enum {
    PAL_USBFS_MONITORS_MAX = 32,
    PAL_USBFS_FDS_MAX = 1 + PAL_BUS_DEVICES_MAX + 2 * PAL_USBFS_CLIENTS_MAX + PAL_USBFS_MONITORS_MAX
};

typedef struct pal_usbfs_server {
    const char* folder;
    int events;
    int monitors[PAL_USBFS_MONITORS_MAX];  ///< programs that listen for plugs; -1: none
    int nodes[PAL_BUS_DEVICES_MAX];        ///< listening; -1 while unplugged
    pal_usbfs_clients clients;
} pal_usbfs_server;

/// Makes the folder and plugs the devices in. False with words in `why`; then close is still due.
bool pal_usbfs_open(pal_usbfs_server* server, pal_bus* bus, const char* folder, char* why, size_t n_why);
/// What to wait for. How many of `fds` were filled in.
size_t pal_usbfs_fds(const pal_usbfs_server* server, struct pollfd fds[PAL_USBFS_FDS_MAX]);
/// Everything that can be done now, without waiting: programs' messages, the bus' time, ended URBs, plugs.
void pal_usbfs_serve(pal_usbfs_server* server);
/// Hangs up on everybody and removes the folder.
void pal_usbfs_close(pal_usbfs_server* server);
/// How many programs have the device of this port open.
uint32_t pal_usbfs_n_open(const pal_usbfs_server* server, uint32_t port);
