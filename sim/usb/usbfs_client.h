/// One program that has a simulated device open, as usbfs_server.h serves it.
#pragma once
#include <stdbool.h>
#include <stdint.h>

#include "sim/usb/bus.h"

enum {
    PAL_USBFS_CLIENTS_MAX = 32,
    PAL_USBFS_URBS_MAX =
        1024  ///< of one program, not delivered yet; the preload library has no room for more
};

typedef struct pal_usbfs_client {
    int urbs, calls, pipe;  ///< -1: none
    bool in_use, greeted;
    uint32_t port;
    uint32_t claimed;  ///< bit n: interface n
    uint32_t n_urbs;   ///< not delivered yet
    pal_urb* unsent;   ///< ended, waiting for room in the socket; oldest first
} pal_usbfs_client;

/// All programs of a bus.
typedef struct pal_usbfs_clients {
    pal_bus* bus;  ///< borrowed
    pal_usbfs_client of[PAL_USBFS_CLIENTS_MAX];
} pal_usbfs_clients;

/// Takes what the program sent: its hello, then URBs. False when it is gone or speaks nonsense; drop it then.
bool pal_usbfs_take_urbs(pal_usbfs_clients* clients, pal_usbfs_client* client);
/// Carries out a call (claim, release, ...) and answers it. False as above.
bool pal_usbfs_take_calls(pal_usbfs_clients* clients, pal_usbfs_client* client);
/// Hands ended URBs of one port to their programs.
void pal_usbfs_reap(pal_usbfs_clients* clients, uint32_t port);
/// Once more for what found no room before.
void pal_usbfs_send_unsent(pal_usbfs_client* client);
/// The program closed its node or died, or the device was unplugged: its claims and URBs end.
void pal_usbfs_drop(pal_usbfs_clients* clients, pal_usbfs_client* client);
