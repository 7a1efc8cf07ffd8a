/// A simulated device in another process: one 16-byte message each way on a Unix SOCK_SEQPACKET socket.
#pragma once
#include "common/err.h"
#include "firmware/core/device.h"
#ifdef __cplusplus
extern "C" {
#endif

typedef struct pal_device_socket {
    int file;
    uint32_t n_refused;  ///< requests that did not fit the socket's queue
} pal_device_socket;

/// Connects to the socket at `path` and fills `device`, whose context is `socket`. PAL_ERR_RANGE: path too
/// long; PAL_ERR_IO: errno says more.
pal_err pal_device_socket_open(pal_device_socket* socket, const char* path, pal_device* device);
void pal_device_socket_close(pal_device_socket* socket);

#ifdef __cplusplus
}
#endif
