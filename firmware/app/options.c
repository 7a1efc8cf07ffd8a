#include "firmware/app/options.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "common/limits.h"
#include "firmware/core/step.h"

enum { RAMP_TICKS_MAX = 1000 * PAL_RAMP_MAX_S };

static const char HELP[] =
    "palpate-loop: the 1 kHz loop between a Falcon and a palpate host\n"
    "\n"
    "usage: palpate-loop --link NAME --device DEVICE [--firmware FILE] [--delta FILE] [--force-max-n X]\n"
    "       [--ramp-ticks N]\n"
    "\n"
    "  --link NAME        shared memory that the host made, such as /palpate-4711\n"
    "  --device link:PATH simulated Falcon at a Unix socket (palpate-falcon-sim serve --socket PATH)\n"
    "  --device usb[:SERIAL]  a Falcon on the USB, the first by serial number without one; it is booted "
    "first\n"
    "  --firmware FILE    for it; else $PALPATE_FALCON_FIRMWARE, else nvent_firmware.bin in\n"
    "                     $XDG_DATA_HOME/palpate or ~/.local/share/palpate\n"
    "  --delta FILE       geometry and gains of another delta, TOML as in firmware/falcon/nf1.toml; without "
    "it\n"
    "                     a Falcon NF1\n"
    "  --force-max-n X    no force above X newtons; 0 < X <= 8.9 (8)\n"
    "  --ramp-ticks N     soft start after homing and after every stop, in ms; 0 to 60000 (1000)\n"
    "  --help             this text\n"
    "\n"
    "palpate run --clock real starts it by itself. By hand, beside a running host:\n"
    "  palpate-loop --link /palpate-4711 --device link:/tmp/falcon.sock --force-max-n 4\n"
    "\n"
    "With a Falcon that is unplugged and comes back it goes on, after booting, homing, and forces off and "
    "on.\n"
    "It ends when the host asks (stop word) or by SIGTERM: exit 0. SIGINT: 130. Host or device gone: 3.\n"
    "Bad arguments: 2. Before it ends it sends 20 packets of zero force.\n";

void pal_loop_options_help(FILE* out) {
    fputs(HELP, out);
}

static bool read_number(const char* text, double low, double high, double* out) {
    char* end = NULL;
    const double value = strtod(text, &end);
    if (end == text || *end != '\0' || !(value >= low && value <= high)) return false;
    *out = value;
    return true;
}

static bool take_device(pal_loop_options* options, const char* value, FILE* complaint) {
    static const char LINK[] = "link:";
    static const char USB[] = "usb";
    const size_t n_link = strlen(LINK);
    const size_t n_usb = strlen(USB);
    options->device_path = NULL;
    options->serial = NULL;
    options->usb = strncmp(value, USB, n_usb) == 0 && (value[n_usb] == '\0' || value[n_usb] == ':');
    if (options->usb && value[n_usb] == '\0') return true;
    if (options->usb && value[n_usb + 1] != '\0') {
        options->serial = value + n_usb + 1;
        return true;
    }
    if (!options->usb && strncmp(value, LINK, n_link) == 0 && value[n_link] != '\0') {
        options->device_path = value + n_link;
        return true;
    }
    fprintf(complaint, "palpate-loop: --device %s: expected link:PATH, usb or usb:SERIAL\n", value);
    return false;
}

// One option and its value. False: not one of ours (`*known` false) or a bad value.
static bool take(pal_loop_options* options, const char* name, const char* value, FILE* complaint) {
    double number = 0.0;
    if (strcmp(name, "--link") == 0) {
        options->link_name = value;
        return true;
    }
    if (strcmp(name, "--device") == 0) return take_device(options, value, complaint);
    if (strcmp(name, "--firmware") == 0) {
        options->firmware = value;
        return true;
    }
    if (strcmp(name, "--delta") == 0) {
        options->delta = value;
        return true;
    }
    if (strcmp(name, "--force-max-n") == 0) {
        if (!read_number(value, 0.0, PAL_FORCE_DEVICE_MAX_N, &number) || !(number > 0.0)) {
            fprintf(complaint, "palpate-loop: --force-max-n %s: expected newtons above 0, at most 8.9\n",
                    value);
            return false;
        }
        options->force_max_n = number < (double)FLT_MIN ? FLT_MIN : (float)number;  // never 0 by rounding
        return true;
    }
    if (strcmp(name, "--ramp-ticks") == 0) {
        if (!read_number(value, 0.0, (double)RAMP_TICKS_MAX, &number)) {
            fprintf(complaint, "palpate-loop: --ramp-ticks %s: expected 0 to 60000\n", value);
            return false;
        }
        options->ramp_ticks = (uint32_t)number;
        return true;
    }
    fprintf(complaint, "palpate-loop: unknown option %s (see --help)\n", name);
    return false;
}

bool pal_loop_options_read(int argc, char** argv, pal_loop_options* options, FILE* complaint) {
    const pal_loop_config config = pal_loop_config_default();
    *options = (pal_loop_options){.force_max_n = config.force_max_n, .ramp_ticks = config.ramp_ticks};
    for (int i = 1; i < argc; i += 2) {
        if (strcmp(argv[i], "--help") == 0) {
            options->help = true;
            return true;
        }
        if (i + 1 >= argc) {
            fprintf(complaint, "palpate-loop: %s: a value is missing (see --help)\n", argv[i]);
            return false;
        }
        if (!take(options, argv[i], argv[i + 1], complaint)) return false;
    }
    if (options->link_name == NULL || (options->device_path == NULL && !options->usb)) {
        fputs("palpate-loop: --link NAME and --device link:PATH or usb are needed (see --help)\n", complaint);
        return false;
    }
    return true;
}
