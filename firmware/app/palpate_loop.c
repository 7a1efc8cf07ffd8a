#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

#include "firmware/app/helper.h"
#include "firmware/app/options.h"
#include "firmware/app/session.h"
#include "firmware/app/warm.h"
#include "firmware/app/zero.h"
#include "firmware/port/linux/clock_loop.h"
#include "firmware/port/linux/delta_file.h"
#include "firmware/port/linux/device_socket.h"
#include "firmware/port/linux/realtime.h"
#include "firmware/port/linux/segment.h"
#include "firmware/port/linux/usb_device.h"
#include "firmware/port/linux/usb_guard.h"

enum { EXIT_ASKED = 0, EXIT_BAD_ARGUMENTS = 2, EXIT_LOST = 3, EXIT_INTERRUPTED = 130 };
static const uint64_t TICK_NS = 1000000;

// Set by signals only; everything else that changes lives in the session.
static volatile sig_atomic_t signal_seen = 0;

static void on_signal(int number) {
    signal_seen = number;
}

static pal_session_end run_ticks(pal_session* session) {
    pal_clock_loop clock;
    pal_session_end end = PAL_SESSION_RUNS;
    pal_clock_loop_start(&clock, TICK_NS);
    while (end == PAL_SESSION_RUNS) {
        const uint64_t t_ns = pal_clock_loop_wait(&clock);
        const pal_session_time now = {
            .t_ns = t_ns, .n_missed = clock.n_missed, .wake_late_ns = clock.late_ns};
        end = pal_session_tick(session, &now);
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
    // A closed terminal or pager must not end the loop in mid-force, nor Ctrl-Z freeze it there.
    action.sa_handler = SIG_IGN;
    sigaction(SIGPIPE, &action, NULL);
    sigaction(SIGTSTP, &action, NULL);
}

// All but those that the tick's own mistakes raise: the helper has them.
static void block_signals(void) {
    static const int OWN[] = {SIGBUS, SIGSEGV, SIGFPE, SIGILL, SIGABRT, SIGTRAP};
    sigset_t blocked;
    sigfillset(&blocked);
    for (size_t i = 0; i < sizeof OWN / sizeof OWN[0]; ++i) sigdelset(&blocked, OWN[i]);
    pthread_sigmask(SIG_BLOCK, &blocked, NULL);
}

static int farewell(pal_session_end end) {
    if (end == PAL_SESSION_HOST_LOST) fputs("palpate-loop: the host is gone; force is zero\n", stderr);
    if (end == PAL_SESSION_DEVICE_GONE) fputs("palpate-loop: the device is gone\n", stderr);
    if (end == PAL_SESSION_SEGMENT_GONE)
        fputs("palpate-loop: the shared segment was truncated; force is zero\n", stderr);
    if (end != PAL_SESSION_ASKED) return EXIT_LOST;
    return signal_seen == SIGINT ? EXIT_INTERRUPTED : EXIT_ASKED;
}

static pal_loop_config config_of(const pal_loop_options* options, const pal_delta_file* delta) {
    pal_loop_config config = pal_loop_config_default();
    config.delta = &delta->delta;
    memcpy(config.centre_m, delta->centre_m, sizeof config.centre_m);
    config.force_max_n = options->force_max_n;
    config.ramp_ticks = options->ramp_ticks;
    if (options->usb)
        config.release_ticks = 0;  // after a loss of a real device only an operator lets forces in
    return config;
}

static int run(const pal_loop_options* options, const pal_delta_file* delta, pal_link* link,
               const pal_device* device) {
    static pal_session session;
    const pal_loop_config config = config_of(options, delta);
    pal_helper helper;
    pal_realtime_grants grants;
    pal_session_begin(&session, link, device, &config, pal_clock_now_ns);
    pal_segment_watch(link, &session.segment_gone);
    // Before the priority is raised: the helper must not inherit it.
    if (!pal_helper_start(&helper, &session, &signal_seen)) {
        fputs("palpate-loop: no thread for checking tables\n", stderr);
        return EXIT_LOST;
    }
    pal_realtime_begin(&options->realtime, &grants);
    pal_link_store(&link->loop.realtime, grants.granted);
    pal_link_store(&link->loop.realtime_refused, grants.refused);
    block_signals();
    (void)pal_warm_loop(&config);
    pal_helper_watch_me(&helper);
    const pal_session_end end = run_ticks(&session);
    pal_helper_stop(&helper);
    pal_session_finish(&session, end);
    pal_realtime_end(&grants);
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
    char path[PAL_LOOP_PATH_BYTES];
    *guard = (pal_usb_guard){.file = -1};
    if (!pal_loop_program_beside("palpate-falcon", path)) return;
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

static int attach(const char* name, pal_segment* segment) {
    uint32_t holder = 0;
    const pal_err err = pal_segment_take(name, segment, &holder);
    if (err == PAL_OK) return 0;
    fprintf(stderr, "palpate-loop: --link %s: %s", name, pal_segment_words(err, errno));
    if (holder != 0) fprintf(stderr, ", process %u", holder);
    fputc('\n', stderr);
    return EXIT_BAD_ARGUMENTS;
}

int main(int argc, char** argv) {
    pal_loop_options options;
    pal_realtime_prepare_process();
    if (!pal_loop_options_read(argc, argv, &options, stderr)) return EXIT_BAD_ARGUMENTS;
    if (options.help) {
        pal_loop_options_help(stdout);
        return 0;
    }
    if (options.zero) return pal_loop_zero(&options);
    static pal_delta_file delta;
    char why[PAL_DELTA_WORDS_BYTES];
    if (!pal_delta_file_read(options.delta, &delta, why) || !pal_realtime_possible(&options.realtime, why)) {
        fprintf(stderr, "palpate-loop: %s\n", why);
        return EXIT_BAD_ARGUMENTS;
    }
    pal_segment segment = {.link = NULL, .file = -1};
    int status = attach(options.link_name, &segment);
    if (status != 0) return status;
    catch_signals();
    status =
        options.usb ? run_usb(&options, &delta, segment.link) : run_socket(&options, &delta, segment.link);
    pal_segment_give(&segment);
    return status;
}
