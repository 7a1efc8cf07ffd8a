// palpate-falcon boot and home.
#include <stdio.h>

#include "firmware/app/falcon_cli.h"

enum { ARMS = 3 };

static void print_json(const pal_falcon_cli* cli, const char* command, int code, double seconds) {
    pal_falcon_status status;
    pal_falcon_sense sense;
    pal_falcon_status_read(&cli->falcon, &status);
    (void)pal_falcon_read(&cli->falcon, &sense);
    const bool failed = code == PAL_EXIT_DEVICE;
    (void)printf("{\"schema\": \"palpate.falcon_%s/1\", \"exit\": %d, \"serial\": ", command, code);
    pal_cli_json_text(stdout, cli->serial);
    (void)printf(", \"stage\": ");
    pal_cli_json_text(stdout, pal_stage_name(status.at_stage));
    (void)printf(", \"failure\": ");
    pal_cli_json_text(stdout, failed ? pal_failure_name(status.failure) : "");
    (void)printf(", \"words\": ");
    pal_cli_json_text(stdout, pal_falcon_words(&cli->falcon));
    (void)printf(", \"attempt\": %u, \"baud\": %u, \"n_image_bytes\": %u, \"n_echoed_bytes\": %u,",
                 status.attempt, status.baud, status.n_image_bytes, status.n_echoed_bytes);
    (void)printf(" \"seconds\": %.3f, \"homed\": %u, \"encoder_counts\": [%d, %d, %d],", seconds, sense.homed,
                 sense.encoder_counts[0], sense.encoder_counts[1], sense.encoder_counts[2]);
    (void)printf(" \"n_exchanges\": %u}\n", sense.n_exchanges);
}

static double seconds_since(uint64_t then_us) {
    return (double)(pal_usb_now_us() - then_us) * 1e-6;
}

int pal_falcon_boot_command(pal_falcon_cli* cli) {
    const uint64_t begun_us = pal_usb_now_us();
    const int code = pal_cli_boot(cli);
    const double seconds = seconds_since(begun_us);
    if (cli->options->json) print_json(cli, "boot", code, seconds);
    if (code != PAL_EXIT_DONE || cli->options->json) return code;
    pal_falcon_status status;
    pal_falcon_status_read(&cli->falcon, &status);
    if (cli->options->no_reload) {
        (void)printf("The firmware that runs answers. Next: palpate-falcon home\n");
    } else {
        (void)printf("Booted in %.2f s, attempt %u of %u at %u baud. Next: palpate-falcon home\n", seconds,
                     status.attempt, status.n_attempts, status.baud);
    }
    return code;
}

// Which arms have come to their origins since the last call.
static void tell_arms(FILE* out, uint8_t homed, uint8_t before) {
    static const char* const NAMES[ARMS] = {"top", "right", "left"};
    for (uint32_t i = 0; i < ARMS; ++i) {
        const uint32_t bit = 1U << i;
        if ((homed & bit) != 0 && (before & bit) == 0)
            (void)fprintf(out, "  the %s arm has its origin\n", NAMES[i]);
        if ((homed & bit) == 0 && (before & bit) != 0)
            (void)fprintf(out, "  the %s arm lost its origin\n", NAMES[i]);
    }
    (void)fflush(out);
}

static int wait_for_homing(pal_falcon_cli* cli) {
    pal_falcon_sense sense;
    uint8_t before = 0;
    const uint64_t begun_us = pal_usb_now_us();
    pal_falcon_state state = pal_falcon_read(&cli->falcon, &sense);
    (void)fprintf(
        cli->words,
        "Hold the grip loosely and pull it towards you as far as it goes, then push it in as far as "
        "it\ngoes, until each of the three arms has been at its stop. The ring is red until then.\n");
    while (state == PAL_FALCON_HOMING || (state == PAL_FALCON_READY && !sense.has_position)) {
        if (pal_cli_interrupted()) return PAL_EXIT_INTERRUPTED;
        if (seconds_since(begun_us) >= cli->options->seconds) {
            (void)fprintf(stderr,
                          "palpate-falcon: not homed within %g s; start again and move the grip further\n",
                          cli->options->seconds);
            return PAL_EXIT_VERDICT;
        }
        (void)pal_cli_turn(cli);
        state = pal_falcon_read(&cli->falcon, &sense);
        tell_arms(cli->words, sense.homed, before);
        before = sense.homed;
    }
    if (state == PAL_FALCON_FAULT) return pal_cli_tell_fault(cli);
    (void)fprintf(cli->words, "Homed. The grip is at (%.1f, %.1f, %.1f) mm: right, up, towards you.\n",
                  1e3 * (double)sense.position_m[0], 1e3 * (double)sense.position_m[1],
                  1e3 * (double)sense.position_m[2]);
    return PAL_EXIT_DONE;
}

int pal_falcon_home(pal_falcon_cli* cli) {
    const uint64_t begun_us = pal_usb_now_us();
    int code = pal_cli_boot(cli);
    if (code == PAL_EXIT_DONE) code = wait_for_homing(cli);
    if (cli->options->json) print_json(cli, "home", code, seconds_since(begun_us));
    return code;
}
