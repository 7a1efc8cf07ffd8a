#include "sim/usb/usbip.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum {
    VERSION = 0x0111,
    REQUEST_DEVLIST = 0x8005,
    REPLY_DEVLIST = 0x0005,
    REQUEST_IMPORT = 0x8003,
    REPLY_IMPORT = 0x0003,
    STATUS_OK = 0,
    STATUS_BUSY = 2,
    STATUS_NO_DEVICE = 4,
    COMMAND_SUBMIT = 1,
    COMMAND_UNLINK = 2,
    RETURN_SUBMIT = 3,
    RETURN_UNLINK = 4,
    OPERATION_BYTES = 8,
    BUS_ID_BYTES = 32,
    PATH_BYTES = 256,
    COMMAND_BYTES = 48,
    SETUP_AT = 40,
    SPEED_FULL = 2,
    FLAG_SHORT_IS_ERROR = 1,
    DESCRIPTOR_INTERFACE = 4,
    ENDPOINT_IN = 0x80,
    TRANSFER_MAX = 1 << 20,
    BACKLOG = 8,
    PEER_BYTES_MAX = 16 << 20  // of URBs in flight and of answers that nobody fetches; as the kernel's usbfs
};

// Bytes in and out, big-endian.

static bool append(pal_usbip_bytes* to, const void* bytes, size_t n) {
    if (to->n + n > to->n_room) {
        const size_t n_room = 2 * (to->n + n) + 1024;
        uint8_t* more = realloc(to->bytes, n_room);
        if (!more) return false;
        to->bytes = more;
        to->n_room = n_room;
    }
    if (n > 0) memcpy(to->bytes + to->n, bytes, n);
    to->n += n;
    return true;
}

static void skip(pal_usbip_bytes* from, size_t n) {
    memmove(from->bytes, from->bytes + n, from->n - n);
    from->n -= n;
}

static uint32_t get32(const uint8_t* at) {
    return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}
static uint16_t get16(const uint8_t* at) {
    return (uint16_t)(at[0] << 8 | at[1]);
}
static void put32(uint8_t* at, uint32_t value) {
    for (int i = 0; i < 4; ++i) at[i] = (uint8_t)(value >> (24 - 8 * i) & 0xFFU);
}
static void put16(uint8_t* at, uint16_t value) {
    at[0] = (uint8_t)(value >> 8);
    at[1] = (uint8_t)(value & 0xFFU);
}

// Who is there.

static void bus_id(uint32_t port, char out[BUS_ID_BYTES]) {
    memset(out, 0, BUS_ID_BYTES);
    (void)snprintf(out, BUS_ID_BYTES, "1-%u", (unsigned)port + 1);
}

static bool append_device(const pal_usbip* s, uint32_t port, pal_usbip_bytes* to) {
    const pal_bus_port* d = &s->bus->ports[port];
    const uint8_t* b = d->device_descriptor;
    uint8_t record[312] = {0};
    char id[BUS_ID_BYTES];
    bus_id(port, id);
    (void)snprintf((char*)record, PATH_BYTES, "/sys/devices/palpate/usb1/%s", id);
    memcpy(record + PATH_BYTES, id, BUS_ID_BYTES);
    put32(record + 288, 1);
    put32(record + 292, d->number);
    put32(record + 296, SPEED_FULL);
    put16(record + 300, (uint16_t)(b[8] | b[9] << 8));
    put16(record + 302, (uint16_t)(b[10] | b[11] << 8));
    put16(record + 304, (uint16_t)(b[12] | b[13] << 8));
    memcpy(record + 306, b + 4, 3);  // class, subclass, protocol
    record[309] = d->configuration[5];
    record[310] = b[17];
    record[311] = d->configuration[4];
    return append(to, record, sizeof record);
}

static bool append_interfaces(const pal_bus_port* d, pal_usbip_bytes* to) {
    uint32_t left = d->configuration[4];
    for (uint32_t at = 0; left > 0 && at + 8 < d->n_configuration && d->configuration[at] >= 2;
         at += d->configuration[at]) {
        const uint8_t* i = &d->configuration[at];
        if (i[1] != DESCRIPTOR_INTERFACE || i[3] != 0) continue;
        const uint8_t classes[4] = {i[5], i[6], i[7], 0};
        if (!append(to, classes, sizeof classes)) return false;
        --left;
    }
    return true;
}

static bool answer_operation(pal_usbip_peer* peer, uint16_t code, uint32_t status) {
    uint8_t head[OPERATION_BYTES];
    put16(head, VERSION);
    put16(head + 2, code);
    put32(head + 4, status);
    return append(&peer->out, head, sizeof head);
}

static bool list_devices(const pal_usbip* s, pal_usbip_peer* peer) {
    uint32_t n = 0;
    for (uint32_t port = 0; port < s->bus->n_ports; ++port) n += s->bus->ports[port].present;
    uint8_t count[4];
    put32(count, n);
    bool good = answer_operation(peer, REPLY_DEVLIST, STATUS_OK) && append(&peer->out, count, sizeof count);
    for (uint32_t port = 0; port < s->bus->n_ports && good; ++port) {
        if (!s->bus->ports[port].present) continue;
        good = append_device(s, port, &peer->out) && append_interfaces(&s->bus->ports[port], &peer->out);
    }
    peer->ends = true;
    return good;
}

static bool import_device(const pal_usbip* s, pal_usbip_peer* peer, const uint8_t* wanted) {
    uint32_t status = STATUS_NO_DEVICE;
    for (uint32_t port = 0; port < s->bus->n_ports; ++port) {
        char id[BUS_ID_BYTES];
        bus_id(port, id);
        if (!s->bus->ports[port].present || strncmp(id, (const char*)wanted, BUS_ID_BYTES) != 0) continue;
        peer->port = port;
        status = pal_usbip_n_open(s, port) == 0 ? STATUS_OK : STATUS_BUSY;
    }
    peer->attached = status == STATUS_OK;
    peer->ends = !peer->attached;
    return answer_operation(peer, REPLY_IMPORT, status) &&
           (!peer->attached || append_device(s, peer->port, &peer->out));
}

// URBs.

static bool answer_command(pal_usbip_peer* peer, uint32_t command, uint32_t sequence, int32_t status,
                           uint32_t n_done) {
    uint8_t head[COMMAND_BYTES] = {0};
    put32(head, command);
    put32(head + 4, sequence);
    put32(head + 20, (uint32_t)status);
    put32(head + 24, n_done);
    return append(&peer->out, head, sizeof head);
}

static bool is_in(const pal_urb* urb) {
    const uint8_t direction = urb->endpoint == 0 ? urb->setup[0] : urb->endpoint;
    return (direction & ENDPOINT_IN) != 0;
}

/// What a transfer takes here.
static size_t bytes_of(uint32_t n_bytes) {
    return sizeof(pal_urb) + n_bytes;
}

static bool submit(pal_usbip* s, pal_usbip_peer* peer, const uint8_t* command, uint32_t n_bytes, bool in) {
    if (peer->n_urb_bytes + bytes_of(n_bytes) > PEER_BYTES_MAX) return false;
    pal_urb* urb = calloc(1, bytes_of(n_bytes));
    if (!urb) return false;
    const uint32_t endpoint = get32(command + 16) & 0x0FU;
    urb->endpoint = (uint8_t)(endpoint == 0 ? 0 : endpoint | (in ? ENDPOINT_IN : 0U));
    memcpy(urb->setup, command + SETUP_AT, sizeof urb->setup);
    urb->data = (uint8_t*)(urb + 1);
    urb->n_bytes = n_bytes;
    urb->short_is_error = (get32(command + 20) & FLAG_SHORT_IS_ERROR) != 0;
    urb->tag = get32(command + 4);
    urb->owner = peer;
    if (!in && n_bytes > 0) memcpy(urb->data, command + COMMAND_BYTES, n_bytes);
    const int code = pal_host_submit(&s->bus->ports[peer->port].host, urb, s->bus->now_us);
    if (code == PAL_HOST_OK) {
        peer->n_urb_bytes += bytes_of(n_bytes);
        return true;
    }
    const uint32_t sequence = get32(command + 4);
    free(urb);
    return answer_command(peer, RETURN_SUBMIT, sequence, code == PAL_HOST_GONE ? PAL_HOST_GONE : -EPIPE, 0);
}

static void reap(pal_usbip* s, uint32_t port) {
    for (pal_urb* urb = pal_host_reap(&s->bus->ports[port].host); urb;
         urb = pal_host_reap(&s->bus->ports[port].host)) {
        pal_usbip_peer* peer = urb->owner;
        if (peer) {
            peer->n_urb_bytes -= bytes_of(urb->n_bytes);
            const bool good =
                peer->out.n < PEER_BYTES_MAX &&
                answer_command(peer, RETURN_SUBMIT, (uint32_t)urb->tag, urb->status, urb->n_done) &&
                (!is_in(urb) || append(&peer->out, urb->data, urb->n_done));
            if (!good) {  // hang up, at once
                peer->ends = true;
                peer->out.n = 0;
            }
        }
        free(urb);
    }
}

static bool unlink_urb(pal_usbip* s, pal_usbip_peer* peer, const uint8_t* command) {
    pal_host* host = &s->bus->ports[peer->port].host;
    reap(s, peer->port);  // what has ended already is answered before the unlink is
    pal_urb* urb = pal_host_find(host, peer, get32(command + 20));
    const bool cancelled = urb && pal_host_cancel(host, urb);
    if (cancelled) {
        urb->owner = NULL;  // it has no answer of its own any more
        peer->n_urb_bytes -= bytes_of(urb->n_bytes);
    }
    return answer_command(peer, RETURN_UNLINK, get32(command + 4), cancelled ? -ECONNRESET : 0, 0);
}

/// Takes one command off the input. 1 taken, 0 not all of it is here, -1 hang up.
static int take_command(pal_usbip* s, pal_usbip_peer* peer) {
    const uint8_t* at = peer->in.bytes;
    if (peer->in.n < COMMAND_BYTES) return 0;
    if (get32(at) == COMMAND_UNLINK) {
        if (!unlink_urb(s, peer, at)) return -1;
        skip(&peer->in, COMMAND_BYTES);
        return 1;
    }
    const uint32_t n_bytes = get32(at + 24);
    const bool in = get32(at + 12) != 0;
    if (get32(at) != COMMAND_SUBMIT || n_bytes > TRANSFER_MAX) return -1;
    const size_t n = COMMAND_BYTES + (in ? 0 : (size_t)n_bytes);
    if (peer->in.n < n) return 0;
    if (!submit(s, peer, at, n_bytes, in)) return -1;
    skip(&peer->in, n);
    return 1;
}

static int take_operation(pal_usbip* s, pal_usbip_peer* peer) {
    const uint8_t* at = peer->in.bytes;
    if (peer->in.n < OPERATION_BYTES || peer->ends) return 0;
    if (get16(at) != VERSION) return -1;
    if (get16(at + 2) == REQUEST_DEVLIST) {
        skip(&peer->in, OPERATION_BYTES);
        return list_devices(s, peer) ? 1 : -1;
    }
    if (get16(at + 2) != REQUEST_IMPORT) return -1;
    if (peer->in.n < OPERATION_BYTES + BUS_ID_BYTES) return 0;
    if (!import_device(s, peer, at + OPERATION_BYTES)) return -1;
    skip(&peer->in, OPERATION_BYTES + BUS_ID_BYTES);
    return 1;
}

// Peers.

static void drop(pal_usbip* s, pal_usbip_peer* peer) {
    if (peer->attached) {
        pal_host* host = &s->bus->ports[peer->port].host;
        pal_host_end(host, peer, PAL_HOST_CANCELLED);
        for (pal_urb* urb = host->done.first; urb; urb = urb->next) {
            if (urb->owner == peer) urb->owner = NULL;
        }
        reap(s, peer->port);
    }
    (void)close(peer->fd);
    free(peer->in.bytes);
    free(peer->out.bytes);
    *peer = (pal_usbip_peer){.fd = -1};
}

/// False: hang up.
static bool take(pal_usbip* s, pal_usbip_peer* peer) {
    uint8_t bytes[16384];
    const ssize_t n = recv(peer->fd, bytes, sizeof bytes, MSG_DONTWAIT);
    if (n < 0) return errno == EAGAIN || errno == EINTR;
    if (n > 0 && peer->ends) return true;  // nobody will look at it
    if (n == 0 || !append(&peer->in, bytes, (size_t)n)) return false;
    int code = 1;
    while (code > 0) code = peer->attached ? take_command(s, peer) : take_operation(s, peer);
    return code == 0;
}

/// False: hang up.
static bool give(pal_usbip_peer* peer) {
    if (peer->out.n > 0) {
        const ssize_t n = send(peer->fd, peer->out.bytes, peer->out.n, MSG_DONTWAIT | MSG_NOSIGNAL);
        if (n < 0) return errno == EAGAIN || errno == EINTR;
        skip(&peer->out, (size_t)n);
    }
    return peer->out.n > 0 || !peer->ends;
}

static void welcome(pal_usbip* s) {
    const int fd = accept4(s->listener, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) return;
    const int on = 1;
    (void)setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    for (int i = 0; i < PAL_USBIP_PEERS_MAX; ++i) {
        if (s->peers[i].fd >= 0) continue;
        s->peers[i] = (pal_usbip_peer){.fd = fd};
        return;
    }
    (void)close(fd);
}

static void look_at_plugs(pal_usbip* s) {
    for (uint32_t port = 0; port < s->bus->n_ports; ++port) {
        if (pal_bus_look(s->bus, port) >= 0) continue;
        reap(s, port);
        for (int i = 0; i < PAL_USBIP_PEERS_MAX; ++i) {
            pal_usbip_peer* peer = &s->peers[i];
            if (peer->fd >= 0 && peer->attached && peer->port == port) peer->ends = true;
        }
    }
}

bool pal_usbip_open(pal_usbip* s, pal_bus* bus, const char* address, uint16_t tcp_port, char* why,
                    size_t n_why) {
    memset(s, 0, sizeof *s);
    s->bus = bus;
    for (int i = 0; i < PAL_USBIP_PEERS_MAX; ++i) s->peers[i].fd = -1;
    struct sockaddr_in where = {.sin_family = AF_INET, .sin_port = htons(tcp_port)};
    socklen_t n_where = sizeof where;
    const int on = 1;
    s->listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    errno = s->listener < 0 ? errno : EADDRNOTAVAIL;
    if (s->listener < 0 || inet_pton(AF_INET, address, &where.sin_addr) != 1 ||
        setsockopt(s->listener, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0 ||
        bind(s->listener, (const struct sockaddr*)&where, sizeof where) != 0 ||
        listen(s->listener, BACKLOG) != 0 ||
        getsockname(s->listener, (struct sockaddr*)&where, &n_where) != 0) {
        (void)snprintf(why, n_why, "TCP port %u at %s: %s; choose another with --port", (unsigned)tcp_port,
                       address, strerror(errno));
        return false;
    }
    s->tcp_port = ntohs(where.sin_port);
    pal_bus_advance(bus);
    look_at_plugs(s);
    return true;
}

size_t pal_usbip_fds(const pal_usbip* s, struct pollfd fds[PAL_USBIP_FDS_MAX]) {
    size_t n = 0;
    fds[n++] = (struct pollfd){.fd = s->listener, .events = POLLIN};
    for (int i = 0; i < PAL_USBIP_PEERS_MAX; ++i) {
        const pal_usbip_peer* peer = &s->peers[i];
        if (peer->fd < 0) continue;
        fds[n++] =
            (struct pollfd){.fd = peer->fd, .events = (short)(peer->out.n > 0 ? POLLIN | POLLOUT : POLLIN)};
    }
    return n;
}

void pal_usbip_serve(pal_usbip* s) {
    pal_bus_advance(s->bus);
    for (int i = 0; i < PAL_USBIP_PEERS_MAX; ++i) {
        if (s->peers[i].fd >= 0 && !take(s, &s->peers[i])) drop(s, &s->peers[i]);
    }
    welcome(s);
    pal_bus_advance(s->bus);
    for (uint32_t port = 0; port < s->bus->n_ports; ++port) reap(s, port);
    look_at_plugs(s);
    for (int i = 0; i < PAL_USBIP_PEERS_MAX; ++i) {
        if (s->peers[i].fd >= 0 && !give(&s->peers[i])) drop(s, &s->peers[i]);
    }
}

void pal_usbip_close(pal_usbip* s) {
    for (int i = 0; i < PAL_USBIP_PEERS_MAX; ++i) {
        if (s->peers[i].fd >= 0) drop(s, &s->peers[i]);
    }
    if (s->listener >= 0) (void)close(s->listener);
    s->listener = -1;
}

uint32_t pal_usbip_n_open(const pal_usbip* s, uint32_t port) {
    uint32_t n = 0;
    for (int i = 0; i < PAL_USBIP_PEERS_MAX; ++i) {
        n += s->peers[i].fd >= 0 && s->peers[i].attached && s->peers[i].port == port;
    }
    return n;
}
