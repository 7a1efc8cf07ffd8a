#include "firmware/app/falcon_options.h"

#include <stdlib.h>
#include <string.h>

static const char HELP[] =
    "palpate-falcon: a Novint Falcon on the USB: find it, boot it, home it, measure it. Never makes a "
    "force.\n"
    "\n"
    "usage: palpate-falcon COMMAND [options]\n"
    "\n"
    "  list          which Falcons are there, and may this user open them\n"
    "  firmware      which firmware file would be loaded, and is it whole; needs no device\n"
    "  boot          load the firmware, up to the first reply; -v: every stage with its bytes\n"
    "  home          boot, then help to find the arms' origins\n"
    "  monitor       position, velocity and buttons ten times a second; goes on after an unplug\n"
    "  rate          how many exchanges a second, how many fail, how long they take; a verdict\n"
    "  zero          requests of zero force to a Falcon whose program has died; loads nothing\n"
    "  force-check   the map from force to motor words, checked by virtual work; needs no device\n"
    "\n"
    "  --serial S       which Falcon; without it the first in the order of serial numbers\n"
    "  --firmware FILE  else $PALPATE_FALCON_FIRMWARE, else nvent_firmware.bin in $XDG_DATA_HOME/palpate or\n"
    "                   ~/.local/share/palpate\n"
    "  --delta FILE     geometry and gains of another delta, TOML as in firmware/falcon/nf1.toml; without "
    "it\n"
    "                   a Falcon NF1 (force-check, home, monitor, rate)\n"
    "  --no-reload      the firmware runs already: ask it by one packet, load nothing\n"
    "  --attempts N     to boot, at most; the upload's rate falls from one to the next (6)\n"
    "  --no-event-char  the bridge sends a reply when its 1 ms timer ends, not at its last byte: slower, for "
    "when\n"
    "                   rate finds 500 exchanges a second or fewer\n"
    "  --after-stdin    zero: first wait for the end of stdin, and do nothing if a 'z' came there\n"
    "  --pcap FILE      keep all USB traffic for Wireshark\n"
    "  --seconds N      monitor: end after N (0: at Ctrl-C); rate: measure for N (5); home: wait for N "
    "(120)\n"
    "  --exchanges N    rate: end after N exchanges instead; 1 to 1000000000\n"
    "  --period-us N    rate: time from request to request; 0: as soon as the reply is here (0)\n"
    "  --rate-min-hz X  rate: fewer exchanges a second are a bad verdict (900)\n"
    "  --json           one JSON document on stdout (monitor: one a line), words on stderr\n"
    "  -v, --verbose    every byte that goes over the wire (home, monitor and rate: while booting)\n"
    "  --help           this text\n"
    "\n"
    "First steps with a new Falcon:\n"
    "  palpate-falcon list                         is it there?\n"
    "  palpate-falcon boot -v                      does it start?\n"
    "  palpate-falcon home                         pull the grip out, push it in\n"
    "  palpate-falcon rate                         is the connection good enough for 1000 forces a second?\n"
    "  palpate-falcon monitor                      move the grip\n"
    "The same without a Falcon, in a simulated one:\n"
    "  palpate-falcon-sim run -- palpate-falcon home --firmware FILE\n"
    "\n"
    "Ctrl-C, SIGTERM and SIGHUP end it with requests of zero force.\n"
    "Exit codes: 0 done, 1 bad verdict (rate, force-check) or not homed in time, 2 bad arguments or no "
    "firmware\n"
    "file, 3 no device, no right to use it, or it failed; 130 interrupted.\n";

void pal_falcon_options_help(FILE* out) {
    (void)fputs(HELP, out);
}

static bool refuse(FILE* complaint, const char* option, const char* value, const char* right) {
    (void)fprintf(complaint, "palpate-falcon: %s %s: %s (see --help)\n", option, value, right);
    return false;
}

static bool read_number(const char* text, double low, double high, double* out) {
    char* end = NULL;
    const double value = strtod(text, &end);
    if (end == text || *end != '\0' || !(value >= low && value <= high)) return false;
    *out = value;
    return true;
}

static bool read_count(const char* text, double low, double high, uint32_t* out) {
    double value = 0.0;
    if (!read_number(text, low, high, &value)) return false;
    *out = (uint32_t)value;
    return (double)*out == value;
}

static bool take_word(pal_falcon_options* options, const char* name) {
    if (strcmp(name, "--json") == 0) {
        options->json = true;
    } else if (strcmp(name, "-v") == 0 || strcmp(name, "--verbose") == 0) {
        options->verbose = true;
    } else if (strcmp(name, "--no-reload") == 0) {
        options->no_reload = true;
    } else if (strcmp(name, "--after-stdin") == 0) {
        options->after_stdin = true;
    } else if (strcmp(name, "--no-event-char") == 0) {
        options->no_event_char = true;
    } else if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0) {
        options->command = PAL_COMMAND_HELP;
    } else {
        return false;
    }
    return true;
}

static bool take_value(pal_falcon_options* options, const char* name, const char* value, FILE* complaint) {
    const char* right = "unknown option";
    bool good = true;
    if (strcmp(name, "--serial") == 0) {
        options->serial = value;
    } else if (strcmp(name, "--firmware") == 0) {
        options->firmware = value;
    } else if (strcmp(name, "--delta") == 0) {
        options->delta = value;
    } else if (strcmp(name, "--pcap") == 0) {
        options->pcap = value;
    } else if (strcmp(name, "--seconds") == 0) {
        right = "expected seconds, 0 to 1000000";
        good = read_number(value, 0.0, 1e6, &options->seconds);
    } else if (strcmp(name, "--exchanges") == 0) {
        right = "expected a whole number, 1 to 1000000000";
        good = read_count(value, 1.0, 1e9, &options->n_exchanges);
    } else if (strcmp(name, "--attempts") == 0) {
        right = "expected a whole number, 1 to 1000";
        good = read_count(value, 1.0, 1000.0, &options->n_attempts);
    } else if (strcmp(name, "--period-us") == 0) {
        right = "expected microseconds, 0 to 1000000";
        good = read_count(value, 0.0, 1e6, &options->period_us);
    } else if (strcmp(name, "--rate-min-hz") == 0) {
        right = "expected exchanges a second, 0 to 1000000";
        good = read_number(value, 0.0, 1e6, &options->rate_min_hz);
    } else {
        good = false;
    }
    return good || refuse(complaint, name, value, right);
}

static bool read_command(const char* word, pal_falcon_options* options) {
    static const struct {
        const char* name;
        pal_falcon_command command;
        double seconds;
    } known[] = {{"list", PAL_COMMAND_LIST, 0.0},       {"firmware", PAL_COMMAND_FIRMWARE, 0.0},
                 {"boot", PAL_COMMAND_BOOT, 0.0},       {"home", PAL_COMMAND_HOME, 120.0},
                 {"monitor", PAL_COMMAND_MONITOR, 0.0}, {"rate", PAL_COMMAND_RATE, 5.0},
                 {"zero", PAL_COMMAND_ZERO, 0.0},       {"force-check", PAL_COMMAND_FORCE_CHECK, 0.0},
                 {"--help", PAL_COMMAND_HELP, 0.0},     {"-h", PAL_COMMAND_HELP, 0.0},
                 {"help", PAL_COMMAND_HELP, 0.0}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        if (strcmp(word, known[i].name) != 0) continue;
        options->command = known[i].command;
        options->seconds = known[i].seconds;
        return true;
    }
    return false;
}

bool pal_falcon_options_read(int argc, char** argv, pal_falcon_options* options, FILE* complaint) {
    *options = (pal_falcon_options){.rate_min_hz = 900.0};
    const char* word = argc > 1 ? argv[1] : "";
    if (!read_command(word, options)) {
        return refuse(complaint, "command", word[0] == '\0' ? "(none)" : word,
                      "expected list, firmware, boot, home, monitor, rate, zero or force-check");
    }
    for (int i = 2; i < argc && options->command != PAL_COMMAND_HELP; ++i) {
        if (take_word(options, argv[i])) continue;
        if (argv[i][0] != '-')
            return refuse(complaint, "argument", argv[i],
                          "unknown; after the command come options, which begin with -");
        if (i + 1 >= argc)
            return refuse(complaint, argv[i], "", "a value is missing, or the option is unknown");
        if (!take_value(options, argv[i], argv[i + 1], complaint)) return false;
        i += 1;
    }
    return true;
}
