#include "firmware/app/falcon_cli.h"

#include <errno.h>
#include <signal.h>
#include <string.h>
#include <time.h>

#include "firmware/port/linux/toml_text.h"

enum { REOPEN_PAUSE_MS = 200, US_PER_MS = 1000 };

// Set by signals only.
static volatile sig_atomic_t signal_seen = 0;

static void on_signal(int number) {
    signal_seen = number;
}

void pal_cli_catch_signals(void) {
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_signal;
    sigemptyset(&action.sa_mask);
    (void)sigaction(SIGINT, &action, NULL);
    (void)sigaction(SIGTERM, &action, NULL);
    (void)sigaction(SIGHUP, &action, NULL);
    action.sa_handler = SIG_IGN;
    (void)sigaction(SIGPIPE, &action, NULL);  // a closed pager must not keep the zero forces from going out
}

bool pal_cli_interrupted(void) {
    return signal_seen != 0;
}

// ---- telling

static double seconds_of(const pal_falcon_cli* cli, uint64_t time_us) {
    return (double)(time_us - cli->start_us) * 1e-6;
}

static void tell_bytes(FILE* out, const pal_falcon_trace_record* record) {
    for (uint32_t i = 0; i < record->n_bytes; ++i) (void)fprintf(out, " %02X", record->bytes[i]);
    (void)fputc('\n', out);
}

static void tell_record(const pal_falcon_cli* cli, const pal_falcon_trace_record* record) {
    const double at_s = seconds_of(cli, record->time_us);
    switch (record->kind) {
        case PAL_TRACE_STAGE: {
            const pal_falcon_stage stage = (pal_falcon_stage)record->request;
            (void)fprintf(cli->words, "%9.4f s  %-11s %s", at_s, pal_stage_name(stage),
                          pal_stage_words(stage));
            if (record->index > 1) (void)fprintf(cli->words, " Attempt %u.", record->index);
            if (record->value != PAL_FAIL_NONE && stage <= PAL_STAGE_CHIP) {
                const pal_falcon_failure failure = (pal_falcon_failure)record->value;
                (void)fprintf(cli->words, " Before: %s.", pal_failure_name(failure));
            }
            (void)fputc('\n', cli->words);
            break;
        }
        case PAL_TRACE_CONTROL:
            if (!cli->options->verbose) break;
            (void)fprintf(cli->words, "%9.4f s      control 40 %02X value %04X index %04X\n", at_s,
                          record->request, record->value, record->index);
            break;
        case PAL_TRACE_WRITE:
        case PAL_TRACE_READ:
            if (!cli->options->verbose) break;
            (void)fprintf(cli->words, "%9.4f s      %s", at_s,
                          record->kind == PAL_TRACE_WRITE ? "out" : "in ");
            tell_bytes(cli->words, record);
            break;
        default:
            break;
    }
}

static void tell_new(pal_falcon_cli* cli) {
    const uint64_t n = cli->trace.n_written;
    if (n > cli->n_told + PAL_CLI_RECORDS) cli->n_told = n - PAL_CLI_RECORDS;
    for (; cli->n_told < n; ++cli->n_told) tell_record(cli, &cli->records[cli->n_told % PAL_CLI_RECORDS]);
    (void)fflush(cli->words);
}

int pal_cli_tell_fault(const pal_falcon_cli* cli) {
    char words[PAL_CLI_WORDS_BYTES];
    (void)pal_falcon_describe(&cli->falcon, words, sizeof words);
    (void)fprintf(stderr, "palpate-falcon: %s\n", words);
    return PAL_EXIT_DEVICE;
}

void pal_cli_json_text(FILE* out, const char* text) {
    size_t n_left = strlen(text);
    (void)fputc('"', out);
    while (n_left > 0) {
        const unsigned char c = (unsigned char)*text;
        const size_t n_bytes = pal_utf8_character_bytes(text, n_left);
        if (n_bytes == 0) {
            (void)fputs("\\ufffd", out);
        } else if (c == '"' || c == '\\') {
            (void)fprintf(out, "\\%c", c);
        } else if (c < 0x20 || c == 0x7F) {
            (void)fprintf(out, "\\u%04x", c);
        } else {
            (void)fwrite(text, n_bytes, 1, out);
        }
        const size_t n_taken = n_bytes > 0 ? n_bytes : 1;
        text += n_taken;
        n_left -= n_taken;
    }
    (void)fputc('"', out);
}

// ---- the device

static int complain(const char* why, int code) {
    (void)fprintf(stderr, "palpate-falcon: %s\n", why);
    return code;
}

static bool prepare(pal_falcon_cli* cli) {
    cli->config.trace = &cli->trace;
    const pal_falcon_refusal refusal = pal_falcon_init(&cli->falcon, &cli->config);
    if (refusal != PAL_FALCON_OK) (void)complain(pal_falcon_refusal_words(refusal), PAL_EXIT_ARGUMENTS);
    return refusal == PAL_FALCON_OK;
}

static int read_firmware(pal_falcon_cli* cli) {
    char why[PAL_FIRMWARE_WORDS_BYTES];
    pal_boot_config* boot = &cli->config.boot;
    if (cli->options->no_reload) {
        boot->reload = PAL_RELOAD_NEVER;
        return PAL_EXIT_DONE;
    }
    if (!pal_firmware_read(cli->options->firmware, &cli->firmware, why))
        return complain(why, PAL_EXIT_ARGUMENTS);
    boot->image = cli->firmware.bytes;
    boot->n_image_bytes = cli->firmware.n_bytes;
    (void)fprintf(cli->words, "firmware %s: %zu bytes, %s, SHA-256 %s\n", cli->firmware.path,
                  cli->firmware.n_bytes,
                  cli->firmware.name != NULL ? cli->firmware.name : "none of the published images",
                  cli->firmware.sha256);
    return PAL_EXIT_DONE;
}

bool pal_cli_delta(const pal_falcon_options* options, pal_delta_file* out) {
    char why[PAL_DELTA_WORDS_BYTES];
    const bool good = pal_delta_file_read(options->delta, out, why);
    if (!good) (void)complain(why, PAL_EXIT_ARGUMENTS);
    return good;
}

// Where positions are searched from stays the driver's own choice for the built-in Falcon.
static bool use_delta(pal_falcon_cli* cli) {
    if (!pal_cli_delta(cli->options, &cli->delta)) return false;
    cli->config.delta = &cli->delta.delta;
    if (cli->options->delta != NULL)
        memcpy(cli->config.pose.start_m, cli->delta.centre_m, sizeof cli->delta.centre_m);
    return true;
}

static int open_device(pal_falcon_cli* cli, const char* serial) {
    char why[PAL_USB_WORDS_BYTES];
    if (!prepare(cli)) return PAL_EXIT_ARGUMENTS;
    const pal_usb_problem problem = pal_usb_falcon_open(&cli->port, &cli->falcon, serial, &cli->pcap, why);
    if (problem != PAL_USB_OK) return complain(why, PAL_EXIT_DEVICE);
    const pal_usb_found* about = &cli->port.link.about;
    (void)snprintf(cli->serial, sizeof cli->serial, "%s", about->serial);
    (void)fprintf(cli->words, "Falcon %s at %s\n", about->serial, about->node);
    return PAL_EXIT_DONE;
}

int pal_cli_open(pal_falcon_cli* cli, const pal_falcon_options* options) {
    memset(cli, 0, sizeof *cli);
    cli->options = options;
    cli->words = options->json ? stderr : stdout;
    cli->trace = (pal_falcon_trace){.records = cli->records, .n_records = PAL_CLI_RECORDS};
    cli->config = pal_falcon_config_default();
    cli->start_us = pal_usb_now_us();
    if (options->command == PAL_COMMAND_RATE) cli->config.exchange.period_us = options->period_us;
    if (options->n_attempts > 0) cli->config.boot.n_attempts = options->n_attempts;
    if (options->no_event_char) {
        cli->config.boot.event_char = false;
        cli->config.boot.run_latency_ms = 1;
    }
    if (!use_delta(cli)) return PAL_EXIT_ARGUMENTS;
    const int code = read_firmware(cli);
    if (code != PAL_EXIT_DONE) return code;
    if (options->pcap != NULL && !pal_pcap_open(&cli->pcap, options->pcap)) {
        (void)fprintf(stderr, "palpate-falcon: --pcap %s: %s\n", options->pcap, strerror(errno));
        return PAL_EXIT_ARGUMENTS;
    }
    return open_device(cli, options->serial);
}

pal_falcon_state pal_cli_turn(pal_falcon_cli* cli) {
    pal_falcon_sense sense;
    pal_usb_falcon_turn(&cli->port, PAL_CLI_TURN_US);
    return pal_falcon_read(&cli->falcon, &sense);
}

int pal_cli_boot(pal_falcon_cli* cli) {
    pal_falcon_state state = PAL_FALCON_BOOTING;
    while (state == PAL_FALCON_BOOTING && !pal_cli_interrupted()) {
        state = pal_cli_turn(cli);
        tell_new(cli);
    }
    if (state == PAL_FALCON_FAULT) return pal_cli_tell_fault(cli);
    return state == PAL_FALCON_BOOTING ? PAL_EXIT_INTERRUPTED : PAL_EXIT_DONE;
}

int pal_cli_reopen(pal_falcon_cli* cli, uint64_t until_us) {
    const struct timespec pause = {.tv_nsec = REOPEN_PAUSE_MS * US_PER_MS * 1000L};
    char why[PAL_USB_WORDS_BYTES];
    pal_usb_problem told = PAL_USB_NONE;  // that it is not there is what is waited for
    pal_usb_falcon_close(&cli->port);
    cli->n_told = cli->trace.n_written;
    (void)fprintf(stderr, "palpate-falcon: waiting for Falcon %s to come back; Ctrl-C ends\n", cli->serial);
    while (!pal_cli_interrupted()) {
        (void)nanosleep(&pause, NULL);
        if (pal_cli_interrupted() || !prepare(cli)) break;
        if (pal_usb_now_us() >= until_us) {
            (void)fprintf(stderr, "palpate-falcon: Falcon %s is not back within %g s\n", cli->serial,
                          cli->options->seconds);
            return PAL_EXIT_DEVICE;
        }
        const char* serial = cli->serial[0] != '\0' ? cli->serial : NULL;
        const pal_usb_problem problem =
            pal_usb_falcon_open(&cli->port, &cli->falcon, serial, &cli->pcap, why);
        if (problem == PAL_USB_OK) {
            (void)fprintf(cli->words, "Falcon %s is back at %s\n", cli->serial, cli->port.link.about.node);
            return PAL_EXIT_DONE;
        }
        if (problem != told && problem != PAL_USB_NONE) (void)complain(why, PAL_EXIT_DEVICE);
        told = problem;
    }
    return PAL_EXIT_INTERRUPTED;
}

int pal_cli_close(pal_falcon_cli* cli, int code) {
    pal_usb_falcon_close(&cli->port);
    if (pal_pcap_close(&cli->pcap)) return code;
    (void)fprintf(stderr, "palpate-falcon: --pcap %s: could not be written whole\n", cli->options->pcap);
    return code == PAL_EXIT_DONE ? PAL_EXIT_DEVICE : code;
}
