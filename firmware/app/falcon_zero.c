// palpate-falcon zero: takes the force away from a Falcon whose program has died.
#include <signal.h>
#include <time.h>

#include "firmware/app/falcon_cli.h"
#include "firmware/port/linux/usb_guard.h"

enum { OPEN_MAX_US = 1000000, OPEN_PAUSE_NS = 5000000, ANSWER_MAX_US = 500000 };

// A program that has just died may still hold the device for a moment.
static pal_usb_problem open_soon(pal_usb_falcon* port, pal_falcon* falcon, const char* serial,
                                 char why[PAL_USB_WORDS_BYTES]) {
    const struct timespec pause = {.tv_nsec = OPEN_PAUSE_NS};
    const uint64_t until_us = pal_usb_now_us() + OPEN_MAX_US;
    pal_usb_problem problem = pal_usb_falcon_open(port, falcon, serial, NULL, why);
    while (problem == PAL_USB_BUSY && pal_usb_now_us() < until_us) {
        (void)nanosleep(&pause, NULL);
        problem = pal_usb_falcon_open(port, falcon, serial, NULL, why);
    }
    return problem;
}

int pal_falcon_zero(const pal_falcon_options* options) {
    static pal_usb_falcon port;
    static pal_falcon falcon;
    char why[PAL_USB_WORDS_BYTES];
    pal_falcon_sense sense;
    pal_falcon_config config = pal_falcon_config_default();
    config.boot.reload = PAL_RELOAD_NEVER;  // its first request is one of zero force
    (void)signal(SIGINT, SIG_IGN);
    (void)signal(SIGTERM, SIG_IGN);
    (void)signal(SIGHUP, SIG_IGN);
    (void)signal(SIGPIPE, SIG_IGN);
    if (options->after_stdin && !pal_usb_guard_is_needed()) return PAL_EXIT_DONE;
    if (pal_falcon_init(&falcon, &config) != PAL_FALCON_OK) return PAL_EXIT_ARGUMENTS;
    if (open_soon(&port, &falcon, options->serial, why) != PAL_USB_OK) {
        (void)fprintf(stderr, "palpate-falcon: %s\n", why);
        return PAL_EXIT_DEVICE;
    }
    const uint64_t until_us = pal_usb_now_us() + ANSWER_MAX_US;
    while (pal_falcon_read(&falcon, &sense) == PAL_FALCON_BOOTING && pal_usb_now_us() < until_us) {
        pal_usb_falcon_turn(&port, PAL_CLI_TURN_US);
    }
    const bool answers = sense.n_exchanges > 0;
    pal_usb_falcon_close(&port);
    (void)fprintf(options->json || options->after_stdin ? stderr : stdout, "palpate-falcon: %s\n",
                  answers ? "the Falcon has got requests of zero force"
                          : "the Falcon does not answer; no firmware runs in it, so it makes no force");
    return answers ? PAL_EXIT_DONE : PAL_EXIT_DEVICE;
}
