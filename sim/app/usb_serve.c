#include "sim/app/usb_serve.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "sim/app/devices.h"
#include "sim/app/local_socket.h"
#include "sim/app/signals.h"
#include "sim/app/usb_status.h"
#include "sim/usb/usbfs_server.h"
#include "sim/usb/usbip.h"

enum {
    N_CONTROLS = 4,
    IDLE_US = 1000,  // so often the devices' own time goes on when nobody asks
    FD_SIGNAL = 0,
    FD_CONTROL_LISTEN,
    FD_CONTROL,
    FD_FRONT = FD_CONTROL + N_CONTROLS,
    N_FDS = FD_FRONT + PAL_USBFS_FDS_MAX + PAL_USBIP_FDS_MAX
};

// Large, and one for each process.
static struct {
    pal_devices devices;
    pal_bus bus;
    pal_usbfs_server usbfs;
    pal_usbip usbip;
    pal_usbmon capture;
} g;

typedef struct service {
    const pal_options* options;
    bool usbip, stop;
    bool opened;         // the front end is to be closed
    const char* folder;  // of usbip, to be removed; NULL: none
    int signals, control;
    int asks[N_CONTROLS];  // connections of people who ask; -1: none
    char control_path[PAL_TREE_PATH_BYTES];
    pid_t parent;
} service;

static bool open_front(service* s, const char* folder, char* why, size_t n_why) {
    s->signals = pal_signals_open();
    if (s->signals < 0) {
        (void)snprintf(why, n_why, "no signals: %s", strerror(errno));
        return false;
    }
    s->opened = true;
    if (!s->usbip) return pal_usbfs_open(&g.usbfs, &g.bus, folder, why, n_why);
    g.usbip.listener = -1;
    if (!pal_tree_make(folder, why, n_why)) return false;
    s->folder = folder;
    return pal_usbip_open(&g.usbip, &g.bus, s->options->listen, (uint16_t)s->options->tcp_port, why, n_why);
}

static bool open_control(service* s, const char* folder, char* why, size_t n_why) {
    (void)snprintf(s->control_path, sizeof s->control_path, "%s/control", folder);
    s->control = pal_socket_listen(s->control_path, why, n_why);
    return s->control >= 0;
}

static uint32_t n_open(const void* context, uint32_t port) {
    const service* s = context;
    return s->usbip ? pal_usbip_n_open(&g.usbip, port) : pal_usbfs_n_open(&g.usbfs, port);
}

static void answer(service* s, int* fd) {
    static char words[PAL_STATUS_BYTES];
    char question[256];
    const ssize_t got = recv(*fd, question, sizeof question - 1, MSG_DONTWAIT);
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (got <= 0) {
        (void)close(*fd);
        *fd = -1;
        return;
    }
    question[got] = '\0';
    question[strcspn(question, "\r\n")] = '\0';
    if (strcmp(question, "quit") == 0) {
        s->stop = true;
        (void)snprintf(words, sizeof words, "{\"quit\":true}\n");
    } else {
        const pal_status_source source = {&g.bus, n_open, s};
        pal_status_answer(&source, question, words);
    }
    (void)send(*fd, words, strlen(words), MSG_DONTWAIT | MSG_NOSIGNAL);
}

static void welcome(service* s) {
    const int fd = accept4(s->control, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) return;
    for (int i = 0; i < N_CONTROLS; ++i) {
        if (s->asks[i] >= 0) continue;
        s->asks[i] = fd;
        return;
    }
    (void)close(fd);
}

static size_t gather(const service* s, struct pollfd fds[N_FDS]) {
    fds[FD_SIGNAL] = (struct pollfd){.fd = s->signals, .events = POLLIN};
    fds[FD_CONTROL_LISTEN] = (struct pollfd){.fd = s->control, .events = POLLIN};
    for (int i = 0; i < N_CONTROLS; ++i) {
        fds[FD_CONTROL + i] = (struct pollfd){.fd = s->asks[i], .events = POLLIN};
    }
    return FD_FRONT +
           (s->usbip ? pal_usbip_fds(&g.usbip, fds + FD_FRONT) : pal_usbfs_fds(&g.usbfs, fds + FD_FRONT));
}

/// False with errno when it cannot wait any longer.
static bool run(service* s) {
    while (!s->stop) {
        struct pollfd fds[N_FDS];
        const size_t n = gather(s, fds);
        const uint64_t wait_us = pal_bus_wait_us(&g.bus, IDLE_US);
        const struct timespec wait = {0, (long)wait_us * 1000};
        if (ppoll(fds, (nfds_t)n, &wait, NULL) < 0 && errno != EINTR) return false;
        if (s->usbip) {
            pal_usbip_serve(&g.usbip);
        } else {
            pal_usbfs_serve(&g.usbfs);
        }
        if (fds[FD_SIGNAL].revents) s->stop = true;
        for (int i = 0; i < N_CONTROLS; ++i) {
            if (s->asks[i] >= 0 && fds[FD_CONTROL + i].revents) answer(s, &s->asks[i]);
        }
        if (fds[FD_CONTROL_LISTEN].revents) welcome(s);
        if (s->options->serve.die_with_parent && getppid() != s->parent) s->stop = true;
    }
    return true;
}

static void close_all(service* s) {
    if (s->opened && s->usbip) pal_usbip_close(&g.usbip);
    if (s->opened && !s->usbip) pal_usbfs_close(&g.usbfs);
    if (s->folder) pal_tree_clear(s->folder);
    for (int i = 0; i < N_CONTROLS; ++i) {
        if (s->asks[i] >= 0) (void)close(s->asks[i]);
    }
    if (s->control >= 0) (void)close(s->control);
    if (s->signals >= 0) (void)close(s->signals);
}

static void tell_how(const service* s, const char* folder) {
    if (s->usbip) {
        const bool everybody = strcmp(s->options->listen, "0.0.0.0") == 0;
        const char* host = everybody ? "HOST" : s->options->listen;
        const unsigned port = g.usbip.tcp_port;
        (void)printf(
            "serving %u device(s) by USB/IP at %s, TCP port %u\n"
            "  usbip --tcp-port %u list -r %s\n"
            "  sudo modprobe vhci-hcd && sudo usbip --tcp-port %u attach -r %s -b 1-1\n",
            (unsigned)g.bus.n_ports, s->options->listen, port, port, host, port, host);
    } else {
        (void)printf(
            "serving %u device(s) at %s\n"
            "in another terminal, for programs that use libusb:\n"
            "  eval \"$(palpate-falcon-sim env --bus %s)\"\n",
            (unsigned)g.bus.n_ports, folder, folder);
    }
    (void)fflush(stdout);
}

static void tell_ready(const service* s, const char* folder, int ready_fd) {
    if (ready_fd < 0) {
        tell_how(s, folder);
        return;
    }
    (void)!write(ready_fd, "", 1);
    (void)close(ready_fd);
}

int pal_usb_serve(pal_options* options, const char* folder, int ready_fd) {
    service s = {.options = options, .usbip = options->verb == PAL_VERB_USBIP, .signals = -1, .control = -1};
    for (int i = 0; i < N_CONTROLS; ++i) s.asks[i] = -1;
    s.parent = getppid();
    (void)prctl(PR_SET_TIMERSLACK, 1UL);
    char why[512] = "";
    uint32_t bad = 0;
    bool good = pal_devices_make(options, &g.devices, why, sizeof why);
    if (good && !pal_bus_init(&g.bus, g.devices.configs, g.devices.n, options->timing,
                              (uint32_t)options->packets_per_frame, &bad)) {
        good = false;
        (void)snprintf(why, sizeof why, "device %u: a parameter makes no sense", (unsigned)bad + 1);
    }
    g.capture.fd = -1;
    (void)signal(SIGPIPE, SIG_IGN);  // FILE may be a pipe whose reader leaves
    if (good && options->pcap_file && !pal_bus_capture(&g.bus, &g.capture, options->pcap_file)) {
        good = false;
        (void)snprintf(why, sizeof why, "--pcap %s: %s; name a file that can be written", options->pcap_file,
                       strerror(errno));
    }
    int code = good ? 0 : PAL_EXIT_BAD_INPUT;
    if (good) {
        code = PAL_EXIT_LINK;
        if (open_front(&s, folder, why, sizeof why) && open_control(&s, folder, why, sizeof why)) {
            tell_ready(&s, folder, ready_fd);
            if (run(&s)) code = 0;
            if (code != 0) (void)snprintf(why, sizeof why, "cannot wait: %s", strerror(errno));
        }
        close_all(&s);
    }
    if (!pal_usbmon_close(&g.capture)) {
        code = code ? code : PAL_EXIT_LINK;
        (void)snprintf(why, sizeof why, "--pcap %s: %s; the capture ends early", options->pcap_file,
                       strerror(g.capture.reason));
    }
    if (code != 0) (void)fprintf(stderr, "palpate-falcon-sim: %s\n", why);
    pal_devices_free(&g.devices);
    return code;
}
