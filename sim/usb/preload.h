/// Inside the preload library: where the bus is, and one open device.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <sys/ioctl.h>
// <sys/ioctl.h> first: the next one needs its macros.
#include <linux/usbdevice_fs.h>

#include "sim/usb/preload_wire.h"

enum { PAL_PRELOAD_PATH_MAX = 512 };
#define PAL_PRELOAD_EXPORT __attribute__((visibility("default")))

/// The bus folder, or NULL when the program was not started for a bus.
const char* pal_preload_bus(void);
/// `path`, or its place in the bus folder when it lies below PAL_BUS_SYS or PAL_BUS_DEV; written to `room`
/// then. "" when it does and there is no bus.
const char* pal_preload_redirect(const char* path, char room[PAL_PRELOAD_PATH_MAX]);
/// False in a child of vfork, whose memory is its parent's: what it closes, it closes for itself alone.
bool pal_preload_owns_memory(void);
/// A connection to a socket of the bus, blocking, with a limit on each wait. -1 with errno.
int pal_preload_connect(const char* path);

/// One open device. Any thread may use it; who closes it must be its last user, as with any descriptor.
typedef struct pal_preload_link pal_preload_link;

/// Opens the device node `node` whose socket is at `path`: a descriptor that polls as usbfs does. -1 with
/// errno.
int pal_preload_link_open(const char* path, const char* node, int flags);
/// The link behind a descriptor; NULL when it is none of ours.
pal_preload_link* pal_preload_link_of(int fd);
/// Forgets the descriptor and gives the link's own resources back. The caller closes `fd` itself.
void pal_preload_link_close(int fd);
/// The same for all descriptors from `first` to `last`.
void pal_preload_link_close_range(unsigned first, unsigned last);
/// "/dev/bus/usb/001/002"
const char* pal_preload_link_node(const pal_preload_link* link);

// As the ioctls of usbfs: 0 or more, or -1 with errno.
int pal_preload_submit(pal_preload_link* link, struct usbdevfs_urb* urb);
int pal_preload_discard(pal_preload_link* link, const struct usbdevfs_urb* urb);
int pal_preload_reap(pal_preload_link* link, struct usbdevfs_urb** urb, bool wait);
int pal_preload_call(pal_preload_link* link, pal_wire_call_kind kind, uint32_t argument);
