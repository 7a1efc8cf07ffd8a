// palpate-falcon zero: takes the force away from a Falcon whose program has died.
#include <signal.h>
#include <time.h>

#include "firmware/app/falcon_cli.h"
#include "firmware/port/linux/usb_guard.h"

enum { OPEN_MAX_US = 1000000, OPEN_PAUSE_NS = 5000000, ANSWER_MAX_US = 500000, N_ASKS = 5 };

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

// Asks until it answers, N_ASKS times at most: a request or its reply may be lost. `falcon` is ready to boot.
static bool gets_zero(pal_usb_falcon* port, pal_falcon* falcon, const pal_falcon_config* config) {
    for (int n = 0; n < N_ASKS && !port->gone; ++n) {
        pal_falcon_sense sense;
        if (n > 0 && pal_falcon_init(falcon, config) != PAL_FALCON_OK) return false;
        const uint64_t until_us = pal_usb_now_us() + ANSWER_MAX_US;
        while (pal_falcon_read(falcon, &sense) == PAL_FALCON_BOOTING && pal_usb_now_us() < until_us) {
            pal_usb_falcon_turn(port, PAL_CLI_TURN_US);
        }
        if (sense.n_exchanges > 0) return true;
    }
    return false;
}

static void tell(const pal_falcon_options* options, const char* serial, bool answers, bool gone) {
    const char* words = answers ? "the Falcon has got requests of zero force"
                        : gone
                            ? "the Falcon was unplugged"
                            : "the Falcon does not answer: most likely no firmware runs in it, and then it "
                              "makes no force; if it pushes, take out its power supply";
    (void)fprintf(options->json || options->after_stdin ? stderr : stdout, "palpate-falcon: %s\n", words);
    if (!options->json) return;
    (void)printf("{\"schema\": \"palpate.falcon_zero/1\", \"serial\": ");
    pal_cli_json_text(stdout, serial);
    (void)printf(", \"answers\": %s, \"words\": ", answers ? "true" : "false");
    pal_cli_json_text(stdout, words);
    (void)printf("}\n");
}

int pal_falcon_zero(const pal_falcon_options* options) {
    static pal_usb_falcon port;
    static pal_falcon falcon;
    char why[PAL_USB_WORDS_BYTES];
    char serial[PAL_USB_TEXT_BYTES];
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
    (void)snprintf(serial, sizeof serial, "%s", port.link.about.serial);
    const bool answers = gets_zero(&port, &falcon, &config);
    const bool gone = port.gone;
    pal_usb_falcon_close(&port);
    tell(options, serial, answers, gone);
    return answers ? PAL_EXIT_DONE : PAL_EXIT_DEVICE;
}
