/// The signals by which a user ends a process.
#pragma once

/// SIGTERM, SIGINT and SIGHUP, blocked, as a descriptor to poll; not those that are ignored. -1 with errno.
int pal_signals_open(void);
