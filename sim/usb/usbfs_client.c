#include "sim/usb/usbfs_client.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include "sim/usb/preload_wire.h"

enum {
    MESSAGES_MAX = 256,  // taken from one client before others have their turn
    DESCRIPTOR_INTERFACE = 4,
    DESCRIPTOR_ENDPOINT = 5,
    ENDPOINT_IN = 0x80,
    TO_DEVICE = 0x00,
    TO_INTERFACE = 0x01,
    TO_ENDPOINT = 0x02,
    CLEAR_FEATURE = 1,
    SET_CONFIGURATION = 9,
    SET_INTERFACE = 11,
    INTERFACES_MAX = 32
};

static void close_fd(int* fd) {
    if (*fd >= 0) (void)close(*fd);
    *fd = -1;
}

// Descriptors.

static uint32_t interfaces_of(const pal_bus_port* device) {
    uint32_t mask = 0;
    for (uint32_t at = 0; at + 2 < device->n_configuration && device->configuration[at] >= 2;
         at += device->configuration[at]) {
        const uint8_t* d = &device->configuration[at];
        if (d[1] == DESCRIPTOR_INTERFACE && d[2] < INTERFACES_MAX) mask |= 1U << d[2];
    }
    return mask;
}

static uint16_t endpoints_of(const pal_bus_port* device, uint8_t direction) {
    unsigned mask = 0;
    for (uint32_t at = 0; at + 2 < device->n_configuration && device->configuration[at] >= 2;
         at += device->configuration[at]) {
        const uint8_t* d = &device->configuration[at];
        if (d[1] == DESCRIPTOR_ENDPOINT && (d[2] & ENDPOINT_IN) == direction) mask |= 1U << (d[2] & 0x0FU);
    }
    return (uint16_t)mask;
}

// Ended URBs on their way to the program.

static bool send_done(const pal_usbfs_client* client, const pal_urb* urb) {
    pal_wire_urb head = {.kind = PAL_WIRE_DONE,
                         .endpoint = urb->endpoint,
                         .tag = urb->tag,
                         .status = urb->status,
                         .n_bytes = urb->n_done};
    const bool in =
        urb->endpoint == 0 ? (urb->setup[0] & ENDPOINT_IN) != 0 : (urb->endpoint & ENDPOINT_IN) != 0;
    struct iovec parts[2] = {{&head, sizeof head}, {urb->data, in ? urb->n_done : 0}};
    const struct msghdr message = {.msg_iov = parts, .msg_iovlen = 2};
    if (sendmsg(client->urbs, &message, MSG_NOSIGNAL | MSG_DONTWAIT) < 0 &&
        (errno == EAGAIN || errno == ENOBUFS)) {
        return false;
    }
    // After the message, never before: a program that then finds its node full has seen the message.
    char byte[8];
    (void)!read(client->pipe, byte, sizeof byte);
    return true;
}

void pal_usbfs_send_unsent(pal_usbfs_client* client) {
    while (client->unsent && send_done(client, client->unsent)) {
        pal_urb* sent = client->unsent;
        client->unsent = sent->next;
        free(sent);
        --client->n_urbs;
    }
}

static void deliver(pal_usbfs_client* client, pal_urb* urb) {
    urb->next = NULL;
    pal_urb** end = &client->unsent;
    while (*end) end = &(*end)->next;
    *end = urb;
    pal_usbfs_send_unsent(client);
}

void pal_usbfs_reap(pal_usbfs_clients* s, uint32_t port) {
    for (pal_urb* urb = pal_host_reap(&s->bus->ports[port].host); urb;
         urb = pal_host_reap(&s->bus->ports[port].host)) {
        pal_usbfs_client* client = urb->owner;
        if (client) {
            deliver(client, urb);
        } else {
            free(urb);
        }
    }
}

void pal_usbfs_drop(pal_usbfs_clients* s, pal_usbfs_client* client) {
    pal_host* host = &s->bus->ports[client->port].host;
    pal_host_end(host, client, PAL_HOST_CANCELLED);
    for (pal_urb* urb = host->done.first; urb; urb = urb->next) {
        if (urb->owner == client) urb->owner = NULL;
    }
    pal_usbfs_reap(s, client->port);
    while (client->unsent) {
        pal_urb* next = client->unsent->next;
        free(client->unsent);
        client->unsent = next;
    }
    close_fd(&client->urbs);
    close_fd(&client->calls);
    close_fd(&client->pipe);  // last: this is what the program sees
    *client = (pal_usbfs_client){.urbs = -1, .calls = -1, .pipe = -1};
}

// Messages of programs.

/// The hello with its two descriptors. False: hang up.
static bool greet(pal_usbfs_clients* s, pal_usbfs_client* client) {
    pal_wire_hello hello = {0};
    struct iovec bytes = {&hello, sizeof hello};
    union {
        char room[CMSG_SPACE(2 * sizeof(int))];
        struct cmsghdr align;
    } control;
    struct msghdr message = {
        .msg_iov = &bytes, .msg_iovlen = 1, .msg_control = &control, .msg_controllen = sizeof control};
    const ssize_t n = recvmsg(client->urbs, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) return true;
    const struct cmsghdr* rights = n > 0 ? CMSG_FIRSTHDR(&message) : NULL;
    if (!rights || rights->cmsg_level != SOL_SOCKET || rights->cmsg_type != SCM_RIGHTS) return false;
    int handed[2] = {-1, -1};
    memcpy(handed, CMSG_DATA(rights), rights->cmsg_len - CMSG_LEN(0));  // one or two: there was no more room
    client->pipe = handed[0];
    client->calls = handed[1];  // ours from here on, also when it is not as it should be
    if (client->calls < 0) return false;
    client->greeted = true;
    (void)fcntl(client->pipe, F_SETFL,
                O_RDONLY | O_NONBLOCK);  // nobody else's pipe may make this process wait
    const bool same = n == (ssize_t)sizeof hello && hello.version == PAL_WIRE_VERSION;
    const pal_bus_port* device = &s->bus->ports[client->port];
    const pal_wire_welcome welcome = {.error = same ? 0 : EPROTO,
                                      .out_endpoints = endpoints_of(device, 0),
                                      .in_endpoints = endpoints_of(device, ENDPOINT_IN)};
    return send(client->urbs, &welcome, sizeof welcome, MSG_NOSIGNAL | MSG_DONTWAIT) > 0 && same;
}

/// An URB that cannot be queued ends with `status`.
static void reject(pal_usbfs_client* client, pal_urb* urb, int32_t status) {
    urb->status = status;
    urb->n_done = 0;
    deliver(client, urb);
}

/// False: not a message of this protocol, hang up.
static bool submit(pal_usbfs_clients* s, pal_usbfs_client* client, const pal_wire_urb* head,
                   const uint8_t* data, size_t n_data) {
    const bool in =
        head->endpoint == 0 ? (head->setup[0] & ENDPOINT_IN) != 0 : (head->endpoint & ENDPOINT_IN) != 0;
    if (head->n_bytes > PAL_WIRE_DATA_MAX || n_data != (in ? 0 : head->n_bytes)) return false;
    if (client->n_urbs == PAL_USBFS_URBS_MAX) return false;
    pal_urb* urb = calloc(1, sizeof *urb + head->n_bytes);
    if (!urb) return false;
    urb->endpoint = head->endpoint;
    memcpy(urb->setup, head->setup, sizeof urb->setup);
    urb->data = (uint8_t*)(urb + 1);
    urb->n_bytes = head->n_bytes;
    urb->short_is_error = head->short_is_error != 0;
    urb->tag = head->tag;
    urb->owner = client;
    if (n_data > 0) memcpy(urb->data, data, n_data);
    ++client->n_urbs;
    const int code = pal_host_submit(&s->bus->ports[client->port].host, urb, s->bus->now_us);
    if (code != PAL_HOST_OK) reject(client, urb, code == PAL_HOST_GONE ? PAL_HOST_GONE : -EINVAL);
    return true;
}

static bool take_message(pal_usbfs_clients* s, pal_usbfs_client* client, const uint8_t* bytes, size_t n) {
    pal_wire_urb head;
    if (n < sizeof head) return false;
    memcpy(&head, bytes, sizeof head);
    if (head.kind == PAL_WIRE_SUBMIT) return submit(s, client, &head, bytes + sizeof head, n - sizeof head);
    if (head.kind != PAL_WIRE_DISCARD) return false;
    pal_host* host = &s->bus->ports[client->port].host;
    pal_urb* urb = pal_host_find(host, client, head.tag);
    if (urb) (void)pal_host_cancel(host, urb);
    return true;
}

bool pal_usbfs_take_urbs(pal_usbfs_clients* s, pal_usbfs_client* client) {
    static uint8_t bytes[sizeof(pal_wire_urb) + PAL_WIRE_DATA_MAX + 1];
    if (!client->greeted) {
        if (!greet(s, client)) return false;
        if (!client->greeted) return true;
    }
    for (int i = 0; i < MESSAGES_MAX; ++i) {
        const ssize_t n = recv(client->urbs, bytes, sizeof bytes, MSG_DONTWAIT);
        if (n < 0 && (errno == EAGAIN || errno == EINTR)) return true;
        if (n <= 0 || !take_message(s, client, bytes, (size_t)n)) return false;
    }
    return true;
}

// Calls.

static int claim(pal_usbfs_clients* s, pal_usbfs_client* client, uint32_t interface) {
    if (interface >= INTERFACES_MAX) return -EINVAL;
    const uint32_t bit = 1U << interface;
    if ((interfaces_of(&s->bus->ports[client->port]) & bit) == 0) return -ENOENT;
    for (int i = 0; i < PAL_USBFS_CLIENTS_MAX; ++i) {
        const pal_usbfs_client* other = &s->of[i];
        if (other->in_use && other != client && other->port == client->port && (other->claimed & bit) != 0) {
            return -EBUSY;
        }
    }
    client->claimed |= bit;
    return 0;
}

static int request(pal_bus_port* port, uint8_t type, uint8_t what, uint16_t value, uint16_t index) {
    const int n = pal_bus_control(port, type, what, value, index, NULL, 0);
    if (n >= 0) return 0;
    return n == PAL_HOST_DEVICE_STALLS ? -EPIPE : -ENODEV;
}

static int carry_out(pal_usbfs_clients* s, pal_usbfs_client* client, const pal_wire_call* call) {
    pal_bus_port* port = &s->bus->ports[client->port];
    const uint16_t low = (uint16_t)(call->argument & 0xFFU);
    const uint16_t high = (uint16_t)(call->argument >> 8 & 0xFFU);
    switch (call->kind) {
        case PAL_WIRE_CLAIM:
            return claim(s, client, call->argument);
        case PAL_WIRE_RELEASE:
            if (call->argument >= INTERFACES_MAX || (client->claimed & 1U << call->argument) == 0)
                return -EINVAL;
            client->claimed &= ~(1U << call->argument);
            return 0;
        case PAL_WIRE_CONFIGURATION:
            return request(port, TO_DEVICE, SET_CONFIGURATION, low, 0);
        case PAL_WIRE_INTERFACE:
            return request(port, TO_INTERFACE, SET_INTERFACE, low, high);
        case PAL_WIRE_CLEAR_HALT:
            return request(port, TO_ENDPOINT, CLEAR_FEATURE, 0, low);
        case PAL_WIRE_RESET:  // the kernel puts the configuration back after a reset of the port
            pal_host_end(&port->host, NULL, PAL_HOST_CANCELLED);
            return request(port, TO_DEVICE, SET_CONFIGURATION, port->configuration[5], 0);
        default:
            return -ENOTTY;
    }
}

bool pal_usbfs_take_calls(pal_usbfs_clients* s, pal_usbfs_client* client) {
    pal_wire_call call;
    if (client->calls < 0) return true;
    const ssize_t n = recv(client->calls, &call, sizeof call, MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) return true;
    if (n != (ssize_t)sizeof call) return false;
    const int32_t answer = carry_out(s, client, &call);
    (void)send(client->calls, &answer, sizeof answer, MSG_NOSIGNAL | MSG_DONTWAIT);
    return true;
}
