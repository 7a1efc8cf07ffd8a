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
    "usage: palpate-loop --link NAME --device link:PATH [--force-max-n X] [--ramp-ticks N]\n"
    "\n"
    "  --link NAME        shared memory that the host made, such as /palpate-4711\n"
    "  --device link:PATH simulated Falcon at a Unix socket (palpate-falcon-sim serve --socket PATH)\n"
    "  --force-max-n X    no force above X newtons; 0 < X <= 8.9 (8)\n"
    "  --ramp-ticks N     soft start after homing and after every stop, in ms; 0 to 60000 (1000)\n"
    "  --help             this text\n"
    "\n"
    "palpate run --clock real starts it by itself. By hand, beside a running host:\n"
    "  palpate-loop --link /palpate-4711 --device link:/tmp/falcon.sock --force-max-n 4\n"
    "\n"
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

// One option and its value. False: not one of ours (`*known` false) or a bad value.
static bool take(pal_loop_options* options, const char* name, const char* value, FILE* complaint) {
    static const char DEVICE_KIND[] = "link:";
    double number = 0.0;
    if (strcmp(name, "--link") == 0) {
        options->link_name = value;
        return true;
    }
    if (strcmp(name, "--device") == 0) {
        if (strncmp(value, DEVICE_KIND, strlen(DEVICE_KIND)) != 0 || value[strlen(DEVICE_KIND)] == '\0') {
            fprintf(complaint, "palpate-loop: --device %s: expected link:PATH\n", value);
            return false;
        }
        options->device_path = value + strlen(DEVICE_KIND);
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
    if (options->link_name == NULL || options->device_path == NULL) {
        fputs("palpate-loop: --link NAME and --device link:PATH are needed (see --help)\n", complaint);
        return false;
    }
    return true;
}
