/// The simulated Falcons on USB as a process: for programs under the preload library, or by USB/IP.
#pragma once
#include "sim/app/options.h"

/// Serves until SIGTERM, SIGINT, "quit" or the parent's death (--die-with-parent). `ready_fd` (-1: none) gets
/// one byte when programs may start. The exit code of the process: 0, 2 or 3.
int pal_usb_serve(pal_options* options, const char* bus_folder, int ready_fd);
