#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

#include "firmware/app/options.h"
#include "firmware/app/session.h"
#include "firmware/port/linux/clock_loop.h"
#include "firmware/port/linux/device_socket.h"
#include "firmware/port/linux/segment.h"

enum { EXIT_ASKED = 0, EXIT_BAD_ARGUMENTS = 2, EXIT_LOST = 3, EXIT_INTERRUPTED = 130 };
enum { FIFO_PRIORITY = 80, HOST_LOOKS_APART = 10 };  // the checker looks for the host every tenth round
static const uint64_t TICK_NS = 1000000;

// Set by signals only; everything else that changes lives in the session.
static volatile sig_atomic_t signal_seen = 0;

static void on_signal(int number) {
    signal_seen = number;
}

typedef struct helper {
    pal_session* session;
    uint32_t stop;  ///< the main thread asks it to end
} helper;

static bool host_process_gone(const pal_session* session) {
    const uint32_t pid = pal_link_load(&session->link->host.pid);
    return pid != 0 && kill((pid_t)pid, 0) != 0 && errno == ESRCH;
}

// Everything slow that must not be in the tick: table checks, signals, the look at the host's process.
static void* run_helper(void* context) {
    helper* self = (helper*)context;
    const struct timespec pause = {.tv_nsec = 1000000};
    for (uint32_t round = 0; pal_link_load(&self->stop) == 0; ++round) {
        (void)pal_intake_check(&self->session->intake);
        if (signal_seen != 0) pal_link_store(&self->session->asked, 1);
        if (round % HOST_LOOKS_APART == 0 && host_process_gone(self->session)) {
            pal_link_store(&self->session->host_gone, 1);
        }
        nanosleep(&pause, NULL);
    }
    return NULL;
}

static pal_session_end run_ticks(pal_session* session) {
    pal_clock_loop clock;
    pal_session_end end = PAL_SESSION_RUNS;
    pal_clock_loop_start(&clock, TICK_NS);
    while (end == PAL_SESSION_RUNS) {
        const uint64_t t_ns = pal_clock_loop_wait(&clock);
        end = pal_session_tick(session, t_ns, clock.n_missed);
    }
    for (int i = 0; i < PAL_SESSION_ZERO_TICKS; ++i) {
        pal_session_send_zero(session);
        (void)pal_clock_loop_wait(&clock);
    }
    return end;
}

static void catch_signals(void) {
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_signal;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    sigaction(SIGHUP, &action, NULL);
}

static int farewell(pal_session_end end) {
    if (end == PAL_SESSION_HOST_LOST) fputs("palpate-loop: the host is gone; force is zero\n", stderr);
    if (end == PAL_SESSION_DEVICE_GONE) fputs("palpate-loop: the device is gone\n", stderr);
    if (end != PAL_SESSION_ASKED) return EXIT_LOST;
    return signal_seen == SIGINT ? EXIT_INTERRUPTED : EXIT_ASKED;
}

static int run(const pal_loop_options* options, pal_link* link, const pal_device* device) {
    static pal_session session;
    pal_loop_config config = pal_loop_config_default();
    config.force_max_n = options->force_max_n;
    config.ramp_ticks = options->ramp_ticks;
    pal_session_begin(&session, link, device, &config, pal_clock_now_ns);
    catch_signals();
    // Before the priority is raised: the helper must not inherit it.
    helper self = {.session = &session, .stop = 0};
    pthread_t thread;
    if (pthread_create(&thread, NULL, run_helper, &self) != 0) {
        fputs("palpate-loop: no thread for checking tables\n", stderr);
        return EXIT_LOST;
    }
    (void)pal_clock_loop_prepare(FIFO_PRIORITY);
    pal_link_store(&link->loop.pid, (uint32_t)getpid());
    const pal_session_end end = run_ticks(&session);
    pal_session_finish(&session, end);
    pal_link_store(&self.stop, 1);
    pthread_join(thread, NULL);
    return farewell(end);
}

int main(int argc, char** argv) {
    pal_loop_options options;
    if (!pal_loop_options_read(argc, argv, &options, stderr)) return EXIT_BAD_ARGUMENTS;
    if (options.help) {
        pal_loop_options_help(stdout);
        return 0;
    }
    pal_link* link = NULL;
    pal_err err = pal_segment_attach(options.link_name, &link);
    if (err != PAL_OK) {
        fprintf(stderr, "palpate-loop: --link %s: %s%s%s\n", options.link_name, pal_err_words(err),
                err == PAL_ERR_IO ? ": " : "", err == PAL_ERR_IO ? strerror(errno) : "");
        return EXIT_BAD_ARGUMENTS;
    }
    pal_device_socket socket;
    pal_device device;
    err = pal_device_socket_open(&socket, options.device_path, &device);
    if (err != PAL_OK) {
        fprintf(stderr, "palpate-loop: --device link:%s: %s\n", options.device_path,
                err == PAL_ERR_IO ? strerror(errno) : "path too long for a socket");
        pal_segment_detach(link);
        return EXIT_LOST;
    }
    const int status = run(&options, link, &device);
    pal_device_socket_close(&socket);
    pal_segment_detach(link);
    return status;
}
