/// palpate-falcon-sim: a Novint Falcon without a Falcon, held by a hand.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim/app/ask.h"
#include "sim/app/devices.h"
#include "sim/app/help.h"
#include "sim/app/options.h"
#include "sim/app/run.h"
#include "sim/app/usb_serve.h"
#include "sim/usb/usbfs_tree.h"

enum { TICKS_PER_S = 1000 };

static int serve_packets(pal_options* o) {
    pal_path_file path;
    char why[512];
    if (!pal_devices_hand(o, &path, why, sizeof why)) {
        (void)fprintf(stderr, "palpate-falcon-sim: %s\n", why);
        return PAL_EXIT_BAD_INPUT;
    }
    pal_falcon_sim_seed(&o->serve.falcon, o->seed);
    o->serve.linger_ticks = (uint32_t)o->linger_s * TICKS_PER_S;
    const int code = pal_serve(&o->serve);
    free(path.points);
    return code;
}

/// status, heal, quit, fault, press: to the bus.
static int ask_bus(const pal_options* o, const char* verb) {
    char path[PAL_TREE_PATH_BYTES];
    char question[256];
    char start[128];
    const char* bus = pal_options_bus(o);
    (void)snprintf(path, sizeof path, "%s/control", bus);
    (void)snprintf(start, sizeof start, "serve --usb --bus %s", bus);
    const char* words = o->rest[0] ? o->rest[0] : "";
    int n;
    if (strcmp(verb, "fault") != 0) {
        n = snprintf(question, sizeof question, "%s%s%s", verb, words[0] == '\0' ? "" : " ", words);
    } else if (words[0] == '\0') {
        return pal_options_refuse("fault", "",
                                  "needs what goes wrong, e.g. fault \"unplug at_s=0 for_s=0.5\"");
    } else if (o->device_index > 0) {
        n = snprintf(question, sizeof question, "fault %llu %s", o->device_index, words);
    } else {
        n = snprintf(question, sizeof question, "fault %s", words);
    }
    if (n < 0 || (size_t)n >= sizeof question)
        return pal_options_refuse(verb, words, "is too long; write at most 240 bytes");
    return pal_ask(path, question, start);
}

static bool is_verb(const char* verb) {
    static const char* const verbs[] = {"serve", "run",  "usbip", "env",  "status",
                                        "heal",  "quit", "fault", "press"};
    for (size_t i = 0; i < sizeof verbs / sizeof verbs[0]; ++i) {
        if (strcmp(verb, verbs[i]) == 0) return true;
    }
    return false;
}

static int carry_out(const char* verb, pal_options* o) {
    const bool takes_words =
        strcmp(verb, "run") == 0 || strcmp(verb, "fault") == 0 || strcmp(verb, "press") == 0;
    const char* extra = o->rest[0] && (!takes_words || (o->verb == PAL_VERB_ASK && o->rest[1]))
                            ? o->rest[takes_words ? 1 : 0]
                            : NULL;
    if (o->device_index > 0 && strcmp(verb, "fault") != 0) {
        return pal_options_refuse("--device", "", "belongs to fault; leave it out");
    }
    if (extra) return pal_options_refuse("argument", extra, "not known here; see --help");
    switch (o->verb) {
        case PAL_VERB_RUN:
            return pal_run(o);
        case PAL_VERB_USB:
        case PAL_VERB_USBIP:
            return pal_usb_serve(o, pal_options_bus(o), -1);
        case PAL_VERB_ASK:
            break;
        case PAL_VERB_SOCKET:
            return strcmp(verb, "serve") == 0 ? serve_packets(o) : pal_serve_ask(o->serve.socket_path, verb);
    }
    return strcmp(verb, "env") == 0 ? pal_env(pal_options_bus(o)) : ask_bus(o, verb);
}

int main(int argc, char** argv) {
    static pal_options options;
    const char* verb = argc > 1 ? argv[1] : "";
    if (strcmp(verb, "--help") == 0 || strcmp(verb, "-h") == 0) return pal_help(stdout);
    if (!is_verb(verb)) {
        (void)pal_help(stderr);
        return PAL_EXIT_BAD_INPUT;
    }
    const int code = pal_options_read(argc - 1, argv + 1, verb, &options);
    if (options.help) return pal_help(stdout);
    return code != 0 ? code : carry_out(verb, &options);
}
