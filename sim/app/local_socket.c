#include "sim/app/local_socket.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

enum { BACKLOG = 4, OWNER_ONLY = 0600, PATIENCE_S = 1 };

static bool address_of(const char* path, struct sockaddr_un* address) {
    memset(address, 0, sizeof *address);
    address->sun_family = AF_UNIX;
    const size_t n = strlen(path);
    if (n == 0 || n >= sizeof address->sun_path) {
        errno = ENAMETOOLONG;
        return false;
    }
    memcpy(address->sun_path, path, n + 1);
    return true;
}

int pal_socket_connect(const char* path) {
    struct sockaddr_un address;
    if (!address_of(path, &address)) return -1;
    const int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    if (fd < 0) return -1;
    const struct timeval patience = {PATIENCE_S, 0};  // of a process that was stopped
    (void)setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    (void)setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    if (connect(fd, (const struct sockaddr*)&address, sizeof address) == 0) return fd;
    const int reason = errno;
    (void)close(fd);
    errno = reason;
    return -1;
}

/// True when nothing is at `path` any more.
static bool clear(const char* path, char* why, size_t n_why) {
    struct stat found;
    if (lstat(path, &found) != 0) return true;
    if (!S_ISSOCK(found.st_mode)) {
        (void)snprintf(why, n_why, "%s: is there and is no socket; name a new path", path);
        return false;
    }
    const int fd = pal_socket_connect(path);
    const bool dead = fd < 0 && errno == ECONNREFUSED;
    if (fd >= 0) (void)close(fd);
    if (!dead) {
        (void)snprintf(why, n_why, "%s: another process serves it; end that or name a new path", path);
        return false;
    }
    if (unlink(path) == 0) return true;
    (void)snprintf(why, n_why, "%s: %s; name a new path", path, strerror(errno));
    return false;
}

int pal_socket_listen(const char* path, char* why, size_t n_why) {
    struct sockaddr_un address;
    (void)snprintf(why, n_why, "%s: ", path);
    const size_t used = strlen(why);
    int fd = -1;
    if (address_of(path, &address)) {
        if (!clear(path, why, n_why)) return -1;
        fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    }
    if (fd >= 0 && fchmod(fd, OWNER_ONLY) == 0 &&
        bind(fd, (const struct sockaddr*)&address, sizeof address) == 0 && listen(fd, BACKLOG) == 0) {
        return fd;
    }
    (void)snprintf(why + used, n_why - used, "%s; name a short path in a folder that can be written",
                   strerror(errno));
    if (fd >= 0) (void)close(fd);
    return -1;
}
