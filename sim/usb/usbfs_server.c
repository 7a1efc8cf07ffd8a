#include "sim/usb/usbfs_server.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "sim/usb/preload_wire.h"

static void close_fd(int* fd) {
    if (*fd >= 0) (void)close(*fd);
    *fd = -1;
}

// Plugs.

static void tell(const pal_usbfs_server* s, int monitor, pal_wire_event_kind kind, uint32_t port) {
    const pal_wire_event event = {kind, port + 1, s->clients.bus->ports[port].number};
    (void)send(monitor, &event, sizeof event, MSG_NOSIGNAL | MSG_DONTWAIT);
}

static void tell_all(const pal_usbfs_server* s, pal_wire_event_kind kind, uint32_t port) {
    for (int i = 0; i < PAL_USBFS_MONITORS_MAX; ++i) {
        if (s->monitors[i] >= 0) tell(s, s->monitors[i], kind, port);
    }
}

static bool show(pal_usbfs_server* s, uint32_t port) {
    const pal_bus_port* device = &s->clients.bus->ports[port];
    char node[PAL_TREE_PATH_BYTES];
    pal_tree_node(s->folder, device, node);
    s->nodes[port] = pal_tree_listen(node);
    if (s->nodes[port] < 0 || !pal_tree_add(s->folder, device, port)) return false;
    tell_all(s, PAL_WIRE_ADD, port);
    return true;
}

static void hide(pal_usbfs_server* s, uint32_t port) {
    pal_usbfs_reap(&s->clients, port);  // pal_bus_look ended them all
    for (int i = 0; i < PAL_USBFS_CLIENTS_MAX; ++i) {
        if (s->clients.of[i].in_use && s->clients.of[i].port == port)
            pal_usbfs_drop(&s->clients, &s->clients.of[i]);
    }
    close_fd(&s->nodes[port]);
    pal_tree_remove(s->folder, &s->clients.bus->ports[port], port);
    tell_all(s, PAL_WIRE_REMOVE, port);
}

static void look_at_plugs(pal_usbfs_server* s) {
    for (uint32_t port = 0; port < s->clients.bus->n_ports; ++port) {
        const int change = pal_bus_look(s->clients.bus, port);
        if (change < 0) hide(s, port);
        if (change > 0 && !show(s, port)) {
            (void)fprintf(stderr, "palpate-falcon-sim: %s: device %u cannot be shown again: %s\n", s->folder,
                          (unsigned)port + 1, strerror(errno));
        }
    }
}

// Newcomers.

static void take_all_urbs(pal_usbfs_server* s) {
    for (int i = 0; i < PAL_USBFS_CLIENTS_MAX; ++i) {
        pal_usbfs_client* client = &s->clients.of[i];
        if (client->in_use && !pal_usbfs_take_urbs(&s->clients, client)) pal_usbfs_drop(&s->clients, client);
    }
}

static void welcome_programs(pal_usbfs_server* s, uint32_t port) {
    for (;;) {
        const int fd =
            s->nodes[port] < 0 ? -1 : accept4(s->nodes[port], NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
        if (fd < 0) return;
        take_all_urbs(s);  // who closed a node before this one was opened is seen to be gone
        int place = 0;
        while (place < PAL_USBFS_CLIENTS_MAX && s->clients.of[place].in_use) ++place;
        if (place == PAL_USBFS_CLIENTS_MAX) {
            (void)close(fd);
            continue;
        }
        s->clients.of[place] =
            (pal_usbfs_client){.urbs = fd, .calls = -1, .pipe = -1, .in_use = true, .port = port};
        if (!pal_usbfs_take_urbs(&s->clients, &s->clients.of[place]))
            pal_usbfs_drop(&s->clients, &s->clients.of[place]);
    }
}

static void welcome_monitors(pal_usbfs_server* s) {
    for (;;) {
        const int fd = accept4(s->events, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
        if (fd < 0) return;
        int place = 0;
        while (place < PAL_USBFS_MONITORS_MAX && s->monitors[place] >= 0) ++place;
        if (place == PAL_USBFS_MONITORS_MAX) {
            (void)close(fd);
            continue;
        }
        s->monitors[place] = fd;
        for (uint32_t port = 0; port < s->clients.bus->n_ports; ++port) {
            if (s->clients.bus->ports[port].present) tell(s, fd, PAL_WIRE_PRESENT, port);
        }
    }
}

static void look_at_monitors(pal_usbfs_server* s) {
    for (int i = 0; i < PAL_USBFS_MONITORS_MAX; ++i) {
        char byte;
        if (s->monitors[i] < 0) continue;
        const ssize_t n = recv(s->monitors[i], &byte, sizeof byte, MSG_DONTWAIT);
        if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) close_fd(&s->monitors[i]);
    }
}

// The whole.

bool pal_usbfs_open(pal_usbfs_server* s, pal_bus* bus, const char* folder, char* why, size_t n_why) {
    memset(s, 0, sizeof *s);
    s->clients.bus = bus;
    s->folder = folder;
    s->events = -1;
    for (int i = 0; i < PAL_USBFS_MONITORS_MAX; ++i) s->monitors[i] = -1;
    for (int i = 0; i < PAL_BUS_DEVICES_MAX; ++i) s->nodes[i] = -1;
    for (int i = 0; i < PAL_USBFS_CLIENTS_MAX; ++i) {
        s->clients.of[i] = (pal_usbfs_client){.urbs = -1, .calls = -1, .pipe = -1};
    }
    if (!pal_tree_make(folder, why, n_why)) {
        s->folder = NULL;
        return false;
    }
    char path[PAL_TREE_PATH_BYTES];
    (void)snprintf(path, sizeof path, "%s/events", folder);
    s->events = pal_tree_listen(path);
    bool good = s->events >= 0;
    pal_bus_advance(bus);
    for (uint32_t port = 0; port < bus->n_ports && good; ++port) {
        if (pal_bus_look(bus, port) > 0) good = show(s, port);
    }
    if (!good)
        (void)snprintf(why, n_why, "%s: %s; the bus folder needs room for a few small files", folder,
                       strerror(errno));
    return good;
}

static size_t add_fd(struct pollfd* fds, size_t n, int fd, bool also_room) {
    if (fd < 0) return n;
    fds[n] = (struct pollfd){.fd = fd, .events = (short)(also_room ? POLLIN | POLLOUT : POLLIN)};
    return n + 1;
}

size_t pal_usbfs_fds(const pal_usbfs_server* s, struct pollfd fds[PAL_USBFS_FDS_MAX]) {
    size_t n = add_fd(fds, 0, s->events, false);
    for (uint32_t i = 0; i < s->clients.bus->n_ports; ++i) n = add_fd(fds, n, s->nodes[i], false);
    for (int i = 0; i < PAL_USBFS_CLIENTS_MAX; ++i) {
        n = add_fd(fds, n, s->clients.of[i].urbs, s->clients.of[i].unsent != NULL);
        n = add_fd(fds, n, s->clients.of[i].calls, false);
    }
    for (int i = 0; i < PAL_USBFS_MONITORS_MAX; ++i) n = add_fd(fds, n, s->monitors[i], false);
    return n;
}

void pal_usbfs_serve(pal_usbfs_server* s) {
    pal_bus_advance(s->clients.bus);
    take_all_urbs(s);
    for (int i = 0; i < PAL_USBFS_CLIENTS_MAX; ++i) {
        pal_usbfs_client* client = &s->clients.of[i];
        if (client->in_use && !pal_usbfs_take_calls(&s->clients, client)) pal_usbfs_drop(&s->clients, client);
    }
    look_at_monitors(s);
    welcome_monitors(s);
    for (uint32_t port = 0; port < s->clients.bus->n_ports; ++port) welcome_programs(s, port);
    pal_bus_advance(s->clients.bus);
    for (uint32_t port = 0; port < s->clients.bus->n_ports; ++port) pal_usbfs_reap(&s->clients, port);
    for (int i = 0; i < PAL_USBFS_CLIENTS_MAX; ++i) pal_usbfs_send_unsent(&s->clients.of[i]);
    look_at_plugs(s);
}

void pal_usbfs_close(pal_usbfs_server* s) {
    for (int i = 0; i < PAL_USBFS_CLIENTS_MAX; ++i) {
        if (s->clients.of[i].in_use) pal_usbfs_drop(&s->clients, &s->clients.of[i]);
    }
    for (int i = 0; i < PAL_BUS_DEVICES_MAX; ++i) close_fd(&s->nodes[i]);
    for (int i = 0; i < PAL_USBFS_MONITORS_MAX; ++i) close_fd(&s->monitors[i]);
    close_fd(&s->events);
    if (s->folder) pal_tree_clear(s->folder);
}

uint32_t pal_usbfs_n_open(const pal_usbfs_server* s, uint32_t port) {
    uint32_t n = 0;
    for (int i = 0; i < PAL_USBFS_CLIENTS_MAX; ++i)
        n += s->clients.of[i].in_use && s->clients.of[i].port == port;
    return n;
}
