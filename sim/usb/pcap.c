#include "sim/usb/pcap.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <string.h>
#include <unistd.h>

enum {
    RECORD_BYTES = 16,  // before each usbmon header: time and lengths
    US_PER_S = 1000000,
    FLUSH_US = US_PER_S,
    PATIENCE_MS = 1000,
    BUS = 1,
    ENDPOINT_IN = 0x80,
    TRANSFER_CONTROL = 2,
    TRANSFER_BULK = 3,
    FLAG_SHORT_IS_ERROR = 0x0001,  // of the kernel's URB
    FLAG_IN = 0x0200,
    SETUP_BYTES = 8
};

// Little-endian, whatever this machine is: the magic number tells readers.

static uint8_t* put(uint8_t* at, uint64_t value, int n_bytes) {
    for (int i = 0; i < n_bytes; ++i) at[i] = (uint8_t)(value >> (8 * i) & 0xFFU);
    return at + n_bytes;
}

static void fail(pal_usbmon* mon, int reason) {
    mon->failed = true;
    mon->reason = reason;
    mon->n = 0;
}

/// Whether a pipe whose reader is slow takes more, within PATIENCE_MS. Else EAGAIN.
static bool has_room(int fd) {
    struct pollfd pipe = {.fd = fd, .events = POLLOUT};
    int n;
    do n = poll(&pipe, 1, PATIENCE_MS);
    while (n < 0 && errno == EINTR);
    errno = n == 0 ? EAGAIN : errno;
    return n > 0;
}

static void flush(pal_usbmon* mon) {
    off_t whole = 0;
    size_t n_done = 0;
    if (mon->n > 0) whole = lseek(mon->fd, 0, SEEK_CUR);
    while (n_done < mon->n) {
        const ssize_t n = write(mon->fd, mon->room + n_done, mon->n - n_done);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0 && errno == EAGAIN && has_room(mon->fd)) continue;
        if (n <= 0) {
            const int reason = n < 0 ? errno : ENOSPC;
            if (whole > 0) (void)!ftruncate(mon->fd, whole);  // no part of a record stays
            fail(mon, reason);
            return;
        }
        n_done += (size_t)n;
    }
    mon->n = 0;
}

bool pal_usbmon_open(pal_usbmon* mon, const char* file, uint64_t begin_us) {
    memset(mon, 0, sizeof *mon);
    mon->begin_us = begin_us;
    mon->fd = open(file, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (mon->fd < 0) return false;
    (void)fcntl(mon->fd, F_SETFL, O_NONBLOCK);     // a pipe must not hold up the devices
    uint8_t* at = put(mon->room, 0xA1B2C3D4U, 4);  // microseconds
    at = put(at, 2, 2);                            // version 2.4
    at = put(at, 4, 2);
    at = put(at, 0, 8);  // times are UTC, of unknown accuracy
    at = put(at, PAL_USBMON_SNAP_BYTES, 4);
    at = put(at, PAL_USBMON_LINK_TYPE, 4);
    mon->n = (size_t)(at - mon->room);
    flush(mon);
    errno = mon->reason;
    if (mon->failed) (void)pal_usbmon_close(mon);
    return !mon->failed;
}

static bool is_in(const pal_urb* urb) {
    return ((urb->endpoint == 0 ? urb->setup[0] : urb->endpoint) & ENDPOINT_IN) != 0;
}

/// The kernel's struct mon_bin_hdr.
static uint8_t* put_header(uint8_t* at, const pal_urb* urb, uint8_t address, uint64_t time_us,
                           uint32_t n_captured) {
    const bool submitted = urb->status == PAL_HOST_PENDING;
    const bool in = is_in(urb);
    const bool control = urb->endpoint == 0;
    const bool has_setup = control && submitted;
    const uint8_t number = urb->endpoint & 0x0FU;
    at = put(at, urb->id, 8);
    *at++ = submitted ? 'S' : 'C';
    *at++ = control ? TRANSFER_CONTROL : TRANSFER_BULK;
    *at++ = in ? number | ENDPOINT_IN : number;
    *at++ = address;
    at = put(at, BUS, 2);
    *at++ = has_setup ? 0 : '-';
    // Of an IN the data stand in 'C', of an OUT in 'S'.
    *at++ = in != submitted ? 0 : (in ? '<' : '>');
    at = put(at, time_us / US_PER_S, 8);
    at = put(at, time_us % US_PER_S, 4);
    at = put(at, (uint32_t)urb->status, 4);
    at = put(at, submitted ? urb->n_bytes : urb->n_done, 4);
    at = put(at, n_captured, 4);
    if (has_setup) memcpy(at, urb->setup, SETUP_BYTES);
    if (!has_setup) memset(at, 0, SETUP_BYTES);
    at = put(at + SETUP_BYTES, 0, 8);  // interval, start frame
    at = put(at, (in ? FLAG_IN : 0U) | (urb->short_is_error ? FLAG_SHORT_IS_ERROR : 0U), 4);
    return put(at, 0, 4);  // isochronous descriptors
}

void pal_usbmon_see(pal_usbmon* mon, uint8_t address, pal_urb* urb, uint64_t now_us) {
    if (mon->fd < 0 || mon->failed) return;
    const bool submitted = urb->status == PAL_HOST_PENDING;
    if (submitted) urb->id = ++mon->last_id;
    const uint32_t n_moved = submitted ? urb->n_bytes : urb->n_done;
    const uint32_t n_data = is_in(urb) != submitted ? n_moved : 0;
    const uint32_t n_most = PAL_USBMON_SNAP_BYTES - PAL_USBMON_HEADER_BYTES;
    const uint32_t n_captured = n_data < n_most ? n_data : n_most;
    if (mon->n + RECORD_BYTES + PAL_USBMON_HEADER_BYTES + n_captured > sizeof mon->room) flush(mon);
    if (mon->failed) return;
    const uint64_t time_us = mon->begin_us + now_us;
    uint8_t* at = mon->room + mon->n;
    at = put(at, time_us / US_PER_S, 4);
    at = put(at, time_us % US_PER_S, 4);
    at = put(at, PAL_USBMON_HEADER_BYTES + n_captured, 4);
    at = put(at, (uint64_t)PAL_USBMON_HEADER_BYTES + n_data, 4);
    at = put_header(at, urb, address, time_us, n_captured);
    if (n_captured > 0) memcpy(at, urb->data, n_captured);
    mon->n = (size_t)(at - mon->room) + n_captured;
    if (now_us - mon->written_us < FLUSH_US) return;
    mon->written_us = now_us;
    flush(mon);
}

bool pal_usbmon_close(pal_usbmon* mon) {
    if (mon->fd < 0) return !mon->failed;
    if (!mon->failed) flush(mon);
    if (close(mon->fd) != 0 && !mon->failed) fail(mon, errno);
    mon->fd = -1;
    return !mon->failed;
}
