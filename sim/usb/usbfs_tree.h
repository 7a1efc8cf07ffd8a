/// The bus folder: what /sys/bus/usb/devices and /dev/bus/usb would show of the simulated devices, for the
/// preload library (preload_wire.h) to lead programs to.
#pragma once
#include <stdbool.h>
#include <stddef.h>

#include "sim/usb/bus.h"

enum { PAL_TREE_FOLDER_MAX = 80, PAL_TREE_PATH_BYTES = 256 };

/// Makes the folder, or empties one that a dead simulator left. False with words in `why`: too long, cannot
/// be written, others can write to it, something else is in it, or another simulator serves it.
bool pal_tree_make(const char* folder, char* why, size_t n_why);
/// Shows the device of port index `port`. The node's socket must listen already. False with errno.
bool pal_tree_add(const char* folder, const pal_bus_port* device, uint32_t port);
/// Hides it and removes its node.
void pal_tree_remove(const char* folder, const pal_bus_port* device, uint32_t port);
/// Path of the node's socket.
void pal_tree_node(const char* folder, const pal_bus_port* device, char out[PAL_TREE_PATH_BYTES]);
/// Removes the folder and all that this module put there.
void pal_tree_clear(const char* folder);
/// A SOCK_SEQPACKET socket listening at `path`, not blocking; what is there is replaced. -1 with errno.
int pal_tree_listen(const char* path);
/// True when somebody serves the bus to programs under the preload library.
bool pal_tree_is_served(const char* folder);
