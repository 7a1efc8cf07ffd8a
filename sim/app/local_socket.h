/// Unix sockets that keep message boundaries.
#pragma once
#include <stddef.h>

/// A listening socket at `path`, for this user alone; what a dead process left there is replaced. -1 with
/// words in `why`.
int pal_socket_listen(const char* path, char* why, size_t n_why);
/// A connection to `path`, blocking, 1 s at most at each call. -1 with errno.
int pal_socket_connect(const char* path);
