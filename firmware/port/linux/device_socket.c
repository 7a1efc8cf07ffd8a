#include "firmware/port/linux/device_socket.h"

#include <errno.h>
#include <stdbool.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "firmware/falcon/wire.h"

enum { REPLIES_MAX = 64 };  // a bound for one tick; a device that floods is served the rest next time

static bool try_again(void) {
    return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR || errno == ENOBUFS;
}

static pal_device_news collect(void* context, uint8_t reply[PAL_WIRE_BYTES]) {
    const pal_device_socket* device = (const pal_device_socket*)context;
    pal_device_news news = PAL_DEVICE_NONE;
    for (int i = 0; i < REPLIES_MAX; ++i) {
        uint8_t bytes[PAL_WIRE_BYTES];
        const ssize_t n_bytes = recv(device->file, bytes, sizeof bytes, MSG_DONTWAIT | MSG_TRUNC);
        if (n_bytes < 0 && try_again()) break;
        if (n_bytes <= 0) return PAL_DEVICE_GONE;
        if (n_bytes != PAL_WIRE_BYTES) continue;
        memcpy(reply, bytes, sizeof bytes);
        news = PAL_DEVICE_FRESH;
    }
    return news;
}

static pal_device_news send_request(void* context, const uint8_t request[PAL_WIRE_BYTES]) {
    pal_device_socket* device = (pal_device_socket*)context;
    if (send(device->file, request, PAL_WIRE_BYTES, MSG_DONTWAIT | MSG_NOSIGNAL) == PAL_WIRE_BYTES) {
        return PAL_DEVICE_FRESH;
    }
    if (!try_again()) return PAL_DEVICE_GONE;
    device->n_refused += 1U;
    return PAL_DEVICE_NONE;
}

pal_err pal_device_socket_open(pal_device_socket* device_socket, const char* path, pal_device* device) {
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof address.sun_path) return PAL_ERR_RANGE;
    memcpy(address.sun_path, path, strlen(path));
    const int file = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    if (file < 0) return PAL_ERR_IO;
    if (connect(file, (const struct sockaddr*)&address, sizeof address) != 0) {
        const int why = errno;
        close(file);
        errno = why;
        return PAL_ERR_IO;
    }
    *device_socket = (pal_device_socket){.file = file};
    *device = (pal_device){.context = device_socket, .collect = collect, .send = send_request};
    return PAL_OK;
}

void pal_device_socket_close(pal_device_socket* device_socket) {
    close(device_socket->file);
    device_socket->file = -1;
}
