#include "sim/app/serve.h"

#include <errno.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

#include "sim/app/ask.h"
#include "sim/app/exit_codes.h"
#include "sim/app/local_socket.h"
#include "sim/app/signals.h"

enum {
    TICK_NS = 1000000,
    CATCH_UP_TICKS_MAX = 50,
    MESSAGES_MAX = 64,  // taken from one client before the clock is looked at again
    N_CONTROLS = 4,
    PATH_BYTES = 128,
    FIFO_PRIORITY = 70,
    ALL_HOMED = 7
};
// The device's listener stands before its client: a client that left before the next one came is then seen to
// be gone.
enum {
    FD_SIGNAL,
    FD_TIMER,
    FD_LISTEN,
    FD_CONTROL_LISTEN,
    FD_DEVICE,
    FD_CONTROL,
    N_FDS = FD_CONTROL + N_CONTROLS
};

typedef struct service {
    const pal_serve_options* options;
    pal_falcon_sim falcon;
    pal_hand hand;
    struct pollfd fds[N_FDS];
    char control_path[PATH_BYTES];
    uint64_t tick, n_lost;
    uint64_t orphan_tick;  // since when the parent is gone; 0: it lives
    pid_t parent;
    bool stop;
} service;

static void hang_up(struct pollfd* client) {
    (void)close(client->fd);
    client->fd = -1;
}

// The device stays for a while, so that somebody can still ask it what its motors do.
static void outlive(service* s) {
    if (s->orphan_tick == 0) s->orphan_tick = s->tick;
    if (s->tick - s->orphan_tick < s->options->linger_ticks) return;
    const pal_falcon_sim* f = &s->falcon;
    (void)fprintf(
        stderr,
        "palpate-falcon-sim: the process that started this one is gone; motor words at the end: %d %d %d\n",
        f->motor_counts[0], f->motor_counts[1], f->motor_counts[2]);
    s->stop = true;
}

static void advance(service* s) {
    uint64_t due = 0;
    if (read(s->fds[FD_TIMER].fd, &due, sizeof due) != (ssize_t)sizeof due) return;
    if (due > CATCH_UP_TICKS_MAX) {
        s->n_lost += due - CATCH_UP_TICKS_MAX;
        due = CATCH_UP_TICKS_MAX;
    }
    for (; due > 0; --due) {
        pal_hand_advance(&s->hand, s->falcon.homed == ALL_HOMED, s->falcon.position_m);
        pal_falcon_sim_advance(&s->falcon, pal_hand_push, &s->hand, s->hand.config.mass_kg);
        ++s->tick;
    }
    if (s->options->die_with_parent && getppid() != s->parent) outlive(s);
}

static void serve_device(service* s) {
    struct pollfd* client = &s->fds[FD_DEVICE];
    for (int n = 0; n < MESSAGES_MAX; ++n) {
        uint8_t bytes[256];
        uint8_t reply[16];
        const ssize_t got = recv(client->fd, bytes, sizeof bytes, MSG_DONTWAIT);
        if (got < 0 && (errno == EAGAIN || errno == EINTR)) return;
        if (got <= 0) {
            hang_up(client);
            return;
        }
        pal_falcon_sim_receive(&s->falcon, bytes, (size_t)got);
        if (!pal_falcon_sim_reply(&s->falcon, reply)) continue;
        (void)send(client->fd, reply, sizeof reply,
                   MSG_DONTWAIT | MSG_NOSIGNAL);  // who does not read loses replies
    }
}

static const char* json_bool(bool value) {
    return value ? "true" : "false";
}

static int write_status(const service* s, char* out, size_t n_out) {
    const pal_falcon_sim* f = &s->falcon;
    double torque_n_m[3];
    for (int i = 0; i < 3; ++i) torque_n_m[i] = 0.0 - (double)f->motor_counts[i] / f->config.units_per_n_m;
    return snprintf(
        out, n_out,
        "{\"tick\":%llu,\"lost_ticks\":%llu,\"connected\":%s,\"motor_counts\":[%d,%d,%d],"
        "\"motor_torque_n_m\":[%.9g,%.9g,%.9g],\"force_n\":[%.9g,%.9g,%.9g],\"position_m\":[%.9g,%.9g,%.9g],"
        "\"homed\":%s,\"watchdog\":%s,\"path_tick\":%u}\n",
        (unsigned long long)s->tick, (unsigned long long)s->n_lost, json_bool(s->fds[FD_DEVICE].fd >= 0),
        f->motor_counts[0], f->motor_counts[1], f->motor_counts[2], torque_n_m[0], torque_n_m[1],
        torque_n_m[2], f->force_n[0], f->force_n[1], f->force_n[2], f->position_m[0], f->position_m[1],
        f->position_m[2], json_bool(f->homed == ALL_HOMED), json_bool(pal_falcon_sim_watchdog(f)),
        s->hand.path_tick);
}

static void serve_control(service* s, struct pollfd* client) {
    char question[64];
    char answer[1024];
    const ssize_t got = recv(client->fd, question, sizeof question - 1, MSG_DONTWAIT);
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (got <= 0) {
        hang_up(client);
        return;
    }
    question[got] = '\0';
    question[strcspn(question, "\r\n")] = '\0';
    int n;
    if (strcmp(question, "status") == 0) {
        n = write_status(s, answer, sizeof answer);
    } else if (strcmp(question, "quit") == 0) {
        s->stop = true;
        n = snprintf(answer, sizeof answer, "{\"quit\":true}\n");
    } else {
        n = snprintf(answer, sizeof answer, "{\"error\":\"unknown word; there are status and quit\"}\n");
    }
    if (n > 0) (void)send(client->fd, answer, (size_t)n, MSG_DONTWAIT | MSG_NOSIGNAL);
}

/// A client for which there is no place is hung up on.
static void welcome(const struct pollfd* listener, struct pollfd* places, int n_places) {
    const int fd = accept4(listener->fd, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) return;
    for (int i = 0; i < n_places; ++i) {
        if (places[i].fd >= 0) continue;
        places[i].fd = fd;
        places[i].revents = 0;
        return;
    }
    (void)close(fd);
}

static void run(service* s) {
    while (!s->stop) {
        if (poll(s->fds, N_FDS, -1) < 0 && errno != EINTR) return;
        if (s->fds[FD_SIGNAL].revents) s->stop = true;
        if (s->fds[FD_TIMER].revents) advance(s);
        if (s->fds[FD_DEVICE].fd >= 0 && s->fds[FD_DEVICE].revents) serve_device(s);
        for (int i = FD_CONTROL; i < N_FDS; ++i) {
            if (s->fds[i].fd >= 0 && s->fds[i].revents) serve_control(s, &s->fds[i]);
        }
        if (s->fds[FD_LISTEN].revents) welcome(&s->fds[FD_LISTEN], &s->fds[FD_DEVICE], 1);
        if (s->fds[FD_CONTROL_LISTEN].revents)
            welcome(&s->fds[FD_CONTROL_LISTEN], &s->fds[FD_CONTROL], N_CONTROLS);
    }
}

static int open_timer(void) {
    struct timespec now;
    if (clock_gettime(CLOCK_MONOTONIC, &now) != 0) return -1;
    const int fd = timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK);
    const struct itimerspec every_ms = {{0, TICK_NS}, now};
    if (fd >= 0 && timerfd_settime(fd, TFD_TIMER_ABSTIME, &every_ms, NULL) == 0) return fd;
    return -1;
}

static bool open_all(service* s, char* why, size_t n_why) {
    const char* path = s->options->socket_path;
    for (int i = 0; i < N_FDS; ++i) s->fds[i] = (struct pollfd){.fd = -1, .events = POLLIN};
    const int n = snprintf(s->control_path, sizeof s->control_path, "%s.control", path);
    if (n < 0 || (size_t)n >= sizeof s->control_path) {
        (void)snprintf(why, n_why, "%s: too long; name a path of at most 99 bytes", path);
        return false;
    }
    s->fds[FD_SIGNAL].fd = pal_signals_open();
    s->fds[FD_LISTEN].fd = pal_socket_listen(path, why, n_why);
    if (s->fds[FD_LISTEN].fd < 0) return false;
    s->fds[FD_CONTROL_LISTEN].fd = pal_socket_listen(s->control_path, why, n_why);
    if (s->fds[FD_CONTROL_LISTEN].fd < 0) return false;
    s->fds[FD_TIMER].fd = open_timer();
    if (s->fds[FD_SIGNAL].fd >= 0 && s->fds[FD_TIMER].fd >= 0) return true;
    (void)snprintf(why, n_why, "no timer or signals: %s", strerror(errno));
    return false;
}

static void close_all(service* s) {
    if (s->fds[FD_LISTEN].fd >= 0) (void)unlink(s->options->socket_path);
    if (s->fds[FD_CONTROL_LISTEN].fd >= 0) (void)unlink(s->control_path);
    for (int i = 0; i < N_FDS; ++i) {
        if (s->fds[i].fd >= 0) hang_up(&s->fds[i]);
    }
}

// A device waits for no other program: below the loop's priority, above everything else, where that is
// allowed.
static void be_prompt(void) {
    const struct sched_param priority = {.sched_priority = FIFO_PRIORITY};
    (void)prctl(PR_SET_TIMERSLACK, 1UL);
    (void)sched_setscheduler(0, SCHED_FIFO, &priority);
}

int pal_serve(const pal_serve_options* options) {
    service s;
    memset(&s, 0, sizeof s);
    s.options = options;
    s.parent = getppid();
    if (!pal_falcon_sim_init(&s.falcon, &options->falcon)) {
        (void)fprintf(stderr, "palpate-falcon-sim: a parameter of the device makes no sense\n");
        return PAL_EXIT_BAD_INPUT;
    }
    pal_hand_init(&s.hand, &options->hand);
    char why[256] = "";
    const bool open = open_all(&s, why, sizeof why);
    if (open) {
        be_prompt();
        run(&s);
    } else {
        (void)fprintf(stderr, "palpate-falcon-sim: %s\n", why);
    }
    close_all(&s);
    return open ? 0 : PAL_EXIT_LINK;
}

int pal_serve_ask(const char* socket_path, const char* question) {
    char path[PATH_BYTES];
    char start[PATH_BYTES];
    (void)snprintf(start, sizeof start, "serve --socket %s", socket_path);
    const int n = snprintf(path, sizeof path, "%s.control", socket_path);
    return pal_ask(n > 0 && (size_t)n < sizeof path ? path : "", question, start);
}
