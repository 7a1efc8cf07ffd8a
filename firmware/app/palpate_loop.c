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
#include "firmware/port/linux/delta_file.h"
#include "firmware/port/linux/device_socket.h"
#include "firmware/port/linux/segment.h"
#include "firmware/port/linux/usb_device.h"
#include "firmware/port/linux/usb_guard.h"

enum { EXIT_ASKED = 0, EXIT_BAD_ARGUMENTS = 2, EXIT_LOST = 3, EXIT_INTERRUPTED = 130 };
enum {
    PATH_BYTES = 4096,
    FIFO_PRIORITY = 80,
    HOST_LOOKS_APART = 10
};  // the checker looks for the host every tenth round
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

static int run(const pal_loop_options* options, const pal_delta_file* delta, pal_link* link,
               const pal_device* device) {
    static pal_session session;
    pal_loop_config config = pal_loop_config_default();
    config.delta = &delta->delta;
    memcpy(config.centre_m, delta->centre_m, sizeof config.centre_m);
    config.force_max_n = options->force_max_n;
    config.ramp_ticks = options->ramp_ticks;
    if (options->usb)
        config.release_ticks = 0;  // after a loss of a real device only an operator lets forces in
    pal_session_begin(&session, link, device, &config, pal_clock_now_ns);
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

static int run_socket(const pal_loop_options* options, const pal_delta_file* delta, pal_link* link) {
    pal_device_socket socket;
    pal_device device;
    const pal_err err = pal_device_socket_open(&socket, options->device_path, &device);
    if (err != PAL_OK) {
        fprintf(stderr, "palpate-loop: --device link:%s: %s\n", options->device_path,
                err == PAL_ERR_IO ? strerror(errno) : "path too long for a socket");
        return EXIT_LOST;
    }
    const int status = run(options, delta, link, &device);
    pal_device_socket_close(&socket);
    return status;
}

// Should this process be killed, palpate-falcon beside it takes the force away.
static void start_guard(pal_usb_guard* guard, const char* serial) {
    static const char NAME[] = "palpate-falcon";
    char path[PATH_BYTES];
    *guard = (pal_usb_guard){.file = -1};
    const ssize_t n = readlink("/proc/self/exe", path, sizeof path - sizeof NAME);
    if (n <= 0) return;
    path[n] = '\0';
    char* name = strrchr(path, '/') + 1;
    memcpy(name, NAME, sizeof NAME);
    if (pal_usb_guard_start(guard, path, serial)) return;
    fprintf(stderr, "palpate-loop: no guard (%s: %s); carrying on without it\n", path, strerror(errno));
}

static int run_usb(const pal_loop_options* options, const pal_delta_file* delta, pal_link* link) {
    static pal_usb_device usb;
    pal_device device;
    char why[PAL_FIRMWARE_WORDS_BYTES];
    pal_usb_device_choice choice = {.serial = options->serial, .firmware = options->firmware};
    if (options->delta != NULL) {
        choice.delta = &delta->delta;
        choice.start_m = delta->centre_m;
    }
    const pal_usb_device_open_result result = pal_usb_device_open(&usb, &choice, &signal_seen, &device, why);
    if (result == PAL_USB_DEVICE_STOPPED) return signal_seen == SIGINT ? EXIT_INTERRUPTED : EXIT_ASKED;
    if (result != PAL_USB_DEVICE_OPEN) {
        fprintf(stderr, "palpate-loop: %s\n", why);
        return result == PAL_USB_DEVICE_NO_FIRMWARE ? EXIT_BAD_ARGUMENTS : EXIT_LOST;
    }
    fprintf(stderr, "palpate-loop: force scale: %g units per N m, assumed, +-15 %%, until calibrated\n",
            (double)usb.config.delta->units_per_n_m);
    pal_usb_guard guard;
    start_guard(&guard, usb.serial);
    const int status = run(options, delta, link, &device);
    pal_usb_device_close(&usb);
    pal_usb_guard_dismiss(&guard);
    return status;
}

int main(int argc, char** argv) {
    pal_loop_options options;
    if (!pal_loop_options_read(argc, argv, &options, stderr)) return EXIT_BAD_ARGUMENTS;
    if (options.help) {
        pal_loop_options_help(stdout);
        return 0;
    }
    static pal_delta_file delta;
    char why[PAL_DELTA_WORDS_BYTES];
    if (!pal_delta_file_read(options.delta, &delta, why)) {
        fprintf(stderr, "palpate-loop: %s\n", why);
        return EXIT_BAD_ARGUMENTS;
    }
    pal_link* link = NULL;
    pal_err err = pal_segment_attach(options.link_name, &link);
    if (err != PAL_OK) {
        fprintf(stderr, "palpate-loop: --link %s: %s%s%s\n", options.link_name, pal_err_words(err),
                err == PAL_ERR_IO ? ": " : "", err == PAL_ERR_IO ? strerror(errno) : "");
        return EXIT_BAD_ARGUMENTS;
    }
    catch_signals();
    const int status = options.usb ? run_usb(&options, &delta, link) : run_socket(&options, &delta, link);
    pal_segment_detach(link);
    return status;
}
