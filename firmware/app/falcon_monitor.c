// palpate-falcon monitor.
#include <stdio.h>
#include <unistd.h>

#include "firmware/app/falcon_cli.h"

enum { LINE_EVERY_US = 100000 };

typedef struct monitor {
    pal_falcon_cli* cli;
    uint64_t line_us;      ///< of the last line
    uint32_t n_exchanges;  ///< then
    bool overwrites;       ///< a terminal: one line, again and again
    bool ran;              ///< the device has answered once
} monitor;

static const char* state_word(pal_falcon_state state) {
    switch (state) {
        case PAL_FALCON_CLOSED:
            return "closed";
        case PAL_FALCON_BOOTING:
            return "booting";
        case PAL_FALCON_HOMING:
            return "homing";
        case PAL_FALCON_READY:
            return "ready";
        case PAL_FALCON_STOPPING:
            return "stopping";
        case PAL_FALCON_FAULT:
            break;
    }
    return "fault";
}

static void print_json(const pal_falcon_sense* s, pal_falcon_state state, double rate_hz) {
    (void)printf("{\"t_us\": %llu, \"state\": \"%s\", \"encoder_counts\": [%d, %d, %d], \"homed\": %u, ",
                 (unsigned long long)s->time_us, state_word(state), s->encoder_counts[0],
                 s->encoder_counts[1], s->encoder_counts[2], s->homed);
    if (s->has_position) {
        (void)printf("\"position_m\": [%.6f, %.6f, %.6f], \"velocity_m_per_s\": [%.4f, %.4f, %.4f], ",
                     (double)s->position_m[0], (double)s->position_m[1], (double)s->position_m[2],
                     (double)s->velocity_m_per_s[0], (double)s->velocity_m_per_s[1],
                     (double)s->velocity_m_per_s[2]);
    }
    (void)printf(
        "\"buttons\": %u, \"rate_hz\": %.1f, \"n_exchanges\": %u, \"n_timeouts\": %u, \"faults_seen\": %u}\n",
        s->buttons, rate_hz, s->n_exchanges, s->n_timeouts, s->faults_seen);
}

static void print_words(const monitor* m, const pal_falcon_sense* s, pal_falcon_state state, double rate_hz) {
    (void)printf("%s%-8s", m->overwrites ? "\r" : "", state_word(state));
    if (s->has_position) {
        (void)printf("  at %7.2f %7.2f %7.2f mm  moving %6.0f %6.0f %6.0f mm/s",
                     1e3 * (double)s->position_m[0], 1e3 * (double)s->position_m[1],
                     1e3 * (double)s->position_m[2], 1e3 * (double)s->velocity_m_per_s[0],
                     1e3 * (double)s->velocity_m_per_s[1], 1e3 * (double)s->velocity_m_per_s[2]);
    } else {
        (void)printf("  encoders %6d %6d %6d  arms homed %u%u%u", s->encoder_counts[0], s->encoder_counts[1],
                     s->encoder_counts[2], s->homed & 1U, (s->homed >> 1U) & 1U, (s->homed >> 2U) & 1U);
    }
    (void)printf("  buttons %c%c%c%c  %6.1f Hz  late %u%s", (s->buttons & 1U) != 0 ? '+' : '.',
                 (s->buttons & 2U) != 0 ? '^' : '.', (s->buttons & 4U) != 0 ? 'o' : '.',
                 (s->buttons & 8U) != 0 ? '-' : '.', rate_hz, s->n_timeouts,
                 m->overwrites ? "\033[K" : "\n");  // the rest of a longer line
}

static void line(monitor* m) {
    pal_falcon_sense sense;
    const uint64_t now_us = pal_usb_now_us();
    const pal_falcon_state state = pal_falcon_read(&m->cli->falcon, &sense);
    if (now_us - m->line_us < LINE_EVERY_US) return;
    const double rate_hz = 1e6 * (double)(sense.n_exchanges - m->n_exchanges) / (double)(now_us - m->line_us);
    m->line_us = now_us;
    m->n_exchanges = sense.n_exchanges;
    if (m->cli->options->json) {
        print_json(&sense, state, rate_hz);
    } else {
        print_words(m, &sense, state, rate_hz);
    }
    (void)fflush(stdout);
}

// Until a fault, the end of the time, a signal, or nobody reads any more.
static int watch(monitor* m, uint64_t until_us) {
    const int code = pal_cli_boot(m->cli);
    if (code != PAL_EXIT_DONE) return code;
    m->ran = true;
    m->line_us = pal_usb_now_us();
    m->n_exchanges = 0;
    while (!pal_cli_interrupted()) {
        if (pal_usb_now_us() >= until_us) return PAL_EXIT_DONE;
        if (pal_cli_turn(m->cli) == PAL_FALCON_FAULT) return pal_cli_tell_fault(m->cli);
        line(m);
        if (ferror(stdout) != 0) return PAL_EXIT_DONE;  // main says so
    }
    return PAL_EXIT_INTERRUPTED;
}

int pal_falcon_monitor(pal_falcon_cli* cli) {
    monitor m = {.cli = cli, .overwrites = !cli->options->json && isatty(STDOUT_FILENO) != 0};
    const double seconds = cli->options->seconds;
    const uint64_t until_us = seconds > 0.0 ? pal_usb_now_us() + (uint64_t)(1e6 * seconds) : UINT64_MAX;
    int code = watch(&m, until_us);
    // A device that once ran is waited for; one that never did is a matter for the user.
    while (code == PAL_EXIT_DEVICE && m.ran) {
        code = pal_cli_reopen(cli, until_us);
        if (code != PAL_EXIT_DONE) break;
        code = watch(&m, until_us);
    }
    if (m.overwrites) (void)putchar('\n');
    return code;
}
