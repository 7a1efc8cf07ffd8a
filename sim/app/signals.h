/// The signals by which a user ends a process.
#pragma once

/// SIGTERM and SIGINT, blocked, as a descriptor to poll. -1 with errno.
int pal_signals_open(void);
