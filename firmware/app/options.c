#include "firmware/app/options.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "common/limits.h"
#include "firmware/core/step.h"

enum { RAMP_TICKS_MAX = 1000 * PAL_RAMP_MAX_S, FIFO_PRIORITY_MAX = 99, CPU_MAX = 4095 };

// One text for each part of it: no compiler has to take more than 4095 characters.
static const char HELP_DEVICE[] =
    "palpate-loop: the 1 kHz loop between a Falcon and a palpate host\n"
    "\n"
    "usage: palpate-loop --link NAME --device DEVICE [options]\n"
    "       palpate-loop --zero --device DEVICE\n"
    "\n"
    "  --link NAME        shared memory that the host made, such as /palpate-4711; of this user, mode 0600, "
    "and\n"
    "                     without another loop\n"
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
    "  --zero             only take the force away from a device whose loop has died: 20 packets of zero "
    "force.\n"
    "                     Nothing is booted or homed\n"
    "  --help             this text\n"
    "\n";

static const char HELP_REALTIME[] =
    "Real time. What the system refuses is said, and how to get it; the loop runs all the same.\n"
    "  --policy fifo      before all ordinary programs of its processor: for nearly everybody (fifo)\n"
    "           deadline  0.2 ms of every millisecond promised, before any fifo; a loop that runs away is "
    "stopped\n"
    "                     instead of holding the processor. Needs CAP_SYS_NICE; not with --cpu\n"
    "           other     as any program: no rights needed; on a busy machine ticks will be late\n"
    "  --priority N       of fifo, 1 to 99 (80). Above 50 it goes before the kernel's interrupt threads: "
    "leave the\n"
    "                     one of the USB above it (chrt -f -p 85 PID)\n"
    "  --cpu N            stay on processor N, best one kept free by isolcpus=N (any)\n"
    "  --no-lock          do not lock memory, where little may be locked; ticks may then wait for the disk\n"
    "\n"
    "palpate run --clock real starts it by itself. By hand, beside a running host:\n"
    "  palpate-loop --link /palpate-4711 --device link:/tmp/falcon.sock --force-max-n 4\n"
    "\n"
    "With a Falcon that is unplugged and comes back it goes on, after booting, homing, and forces off and "
    "on.\n"
    "It ends when the host asks (stop word) or by SIGTERM: exit 0. SIGINT: 130. Host, device or segment "
    "gone: 3.\n"
    "Bad arguments: 2. Before it ends it sends 20 packets of zero force.\n";

void pal_loop_options_help(FILE* out) {
    fputs(HELP_DEVICE, out);
    fputs(HELP_REALTIME, out);
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

static bool take_number(pal_loop_options* options, const char* name, const char* value, FILE* complaint) {
    double number = 0.0;
    if (strcmp(name, "--force-max-n") == 0) {
        if (!read_number(value, 0.0, PAL_FORCE_DEVICE_MAX_N, &number) || !(number > 0.0)) {
            fprintf(complaint, "palpate-loop: --force-max-n %s: expected newtons above 0, at most 8.9\n",
                    value);
            return false;
        }
        options->force_max_n = number < (double)FLT_MIN ? FLT_MIN : (float)number;  // never 0 by rounding
        return true;
    }
    if (!read_number(value, 0.0, (double)RAMP_TICKS_MAX, &number)) {
        fprintf(complaint, "palpate-loop: --ramp-ticks %s: expected 0 to 60000\n", value);
        return false;
    }
    options->ramp_ticks = (uint32_t)number;
    return true;
}

static bool take_policy(pal_policy* policy, const char* value, FILE* complaint) {
    static const char* const NAMES[] = {"fifo", "deadline", "other"};
    for (int i = 0; i < 3; ++i) {
        if (strcmp(value, NAMES[i]) != 0) continue;
        *policy = (pal_policy)i;
        return true;
    }
    fprintf(complaint, "palpate-loop: --policy %s: expected fifo, deadline or other\n", value);
    return false;
}

static bool take_whole(int* out, const char* name, const char* value, int low, int high, FILE* complaint) {
    double number = 0.0;
    if (!read_number(value, low, high, &number) || number != (double)(int)number) {
        fprintf(complaint, "palpate-loop: %s %s: expected a whole number, %d to %d\n", name, value, low,
                high);
        return false;
    }
    *out = (int)number;
    return true;
}

// One option and its value. False: not one of ours, or a bad value.
static bool take(pal_loop_options* options, const char* name, const char* value, FILE* complaint) {
    pal_realtime_choice* realtime = &options->realtime;
    if (strcmp(name, "--device") == 0) return take_device(options, value, complaint);
    if (strcmp(name, "--policy") == 0) return take_policy(&realtime->policy, value, complaint);
    if (strcmp(name, "--priority") == 0)
        return take_whole(&realtime->priority, name, value, 1, FIFO_PRIORITY_MAX, complaint);
    if (strcmp(name, "--cpu") == 0) return take_whole(&realtime->cpu, name, value, 0, CPU_MAX, complaint);
    if (strcmp(name, "--force-max-n") == 0 || strcmp(name, "--ramp-ticks") == 0)
        return take_number(options, name, value, complaint);
    if (strcmp(name, "--link") == 0) {
        options->link_name = value;
    } else if (strcmp(name, "--firmware") == 0) {
        options->firmware = value;
    } else if (strcmp(name, "--delta") == 0) {
        options->delta = value;
    } else {
        fprintf(complaint, "palpate-loop: unknown option %s (see --help)\n", name);
        return false;
    }
    return true;
}

// An option without a value.
static bool take_flag(pal_loop_options* options, const char* name) {
    if (strcmp(name, "--zero") == 0) {
        options->zero = true;
    } else if (strcmp(name, "--no-lock") == 0) {
        options->realtime.lock_memory = false;
    } else {
        return false;
    }
    return true;
}

// What is wrong with all of them together; NULL: nothing.
static const char* conflict(const pal_loop_options* options) {
    const pal_realtime_choice* realtime = &options->realtime;
    const bool device = options->device_path != NULL || options->usb;
    if (options->zero && !device) return "--zero needs --device link:PATH or usb";
    if (options->zero && options->link_name != NULL) return "--zero needs no --link";
    if (!options->zero && (options->link_name == NULL || !device))
        return "--link NAME and --device link:PATH or usb are needed";
    if (realtime->priority != 0 && realtime->policy != PAL_POLICY_FIFO)
        return "--priority belongs to --policy fifo";
    if (realtime->cpu != PAL_REALTIME_ANY_CPU && realtime->policy == PAL_POLICY_DEADLINE)
        return "--cpu: the kernel keeps no thread with a deadline on one processor; use --policy fifo";
    return NULL;
}

bool pal_loop_options_read(int argc, char** argv, pal_loop_options* options, FILE* complaint) {
    const pal_loop_config config = pal_loop_config_default();
    *options = (pal_loop_options){
        .force_max_n = config.force_max_n,
        .ramp_ticks = config.ramp_ticks,
        .realtime = {.policy = PAL_POLICY_FIFO, .cpu = PAL_REALTIME_ANY_CPU, .lock_memory = true},
    };
    for (int i = 1; i < argc; ++i) {
        if (strcmp(argv[i], "--help") == 0) {
            options->help = true;
            return true;
        }
        if (take_flag(options, argv[i])) continue;
        if (i + 1 >= argc) {
            fprintf(complaint, "palpate-loop: %s: a value is missing (see --help)\n", argv[i]);
            return false;
        }
        if (!take(options, argv[i], argv[i + 1], complaint)) return false;
        ++i;
    }
    const char* wrong = conflict(options);
    if (wrong != NULL) fprintf(complaint, "palpate-loop: %s (see --help)\n", wrong);
    if (options->realtime.priority == 0) options->realtime.priority = PAL_REALTIME_PRIORITY;
    return wrong == NULL;
}
