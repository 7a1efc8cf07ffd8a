#include "sim/app/options.h"

#include <arpa/inet.h>
#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "sim/usb/preload_wire.h"

enum {
    TICKS_MAX = 10000000,
    LINGER_MAX_S = 3600,
    TCP_PORT_MAX = 65535,
    USBIP_PORT = 3240,
    USB_VERBS = PAL_VERB_USB | PAL_VERB_RUN | PAL_VERB_USBIP
};

int pal_options_refuse(const char* option, const char* value, const char* right) {
    (void)fprintf(stderr, "palpate-falcon-sim: %s %s: %s\n", option, value, right);
    return PAL_EXIT_BAD_INPUT;
}

static bool parse_count(const char* text, unsigned long long min, unsigned long long max,
                        unsigned long long* out) {
    char* end;
    errno = 0;
    *out = strtoull(text, &end, 10);
    return end != text && *end == '\0' && errno == 0 && text[0] != '-' && *out >= min && *out <= max;
}

static bool parse_number(const char* text, double min, double max, double* out) {
    char* end;
    *out = strtod(text, &end);
    return end != text && *end == '\0' && *out >= min && *out <= max;
}

static bool parse_grip(const char* text, pal_hand_config* hand) {
    static const struct {
        const char* name;
        double grip[3];
    } known[] = {{"none", {0.0, 0.0, 0.0}}, {"light", {0.05, 150.0, 2.0}}, {"firm", {0.15, 500.0, 8.0}}};
    double grip[3] = {0.0, 0.0, 0.0};
    bool good = false;
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        if (strcmp(text, known[i].name) != 0) continue;
        memcpy(grip, known[i].grip, sizeof grip);
        good = true;
    }
    const char* at = text;
    for (int i = 0; i < 3 && !good; ++i) {
        char* end;
        grip[i] = strtod(at, &end);
        if (end == at || *end != (i < 2 ? ',' : '\0') || !(grip[i] >= 0.0 && grip[i] <= 1e5)) return false;
        at = end + 1;
    }
    hand->mass_kg = grip[0];
    hand->stiffness_n_per_m = grip[1];
    hand->damping_n_s_per_m = grip[2];
    return true;
}

typedef enum option_id {
    OPTION_SOCKET = 1,
    OPTION_USB,
    OPTION_PATH,
    OPTION_GRIP,
    OPTION_RAMP,
    OPTION_SEED,
    OPTION_WATCHDOG,
    OPTION_SCALE,
    OPTION_DIE,
    OPTION_LINGER,
    OPTION_BUS,
    OPTION_SERIAL,
    OPTION_DEVICES,
    OPTION_TIMING,
    OPTION_PACKETS,
    OPTION_FAULTS,
    OPTION_RUNNING,
    OPTION_ZERO,
    OPTION_XOFF,
    OPTION_AUTOBAUD,
    OPTION_KEEPS,
    OPTION_LINES,
    OPTION_HOME,
    OPTION_LISTEN,
    OPTION_PORT,
    OPTION_DEVICE,
    OPTION_PCAP,
    OPTION_HELP,
    N_OPTIONS
} option_id;

static const struct option known[] = {
    {"socket", required_argument, NULL, OPTION_SOCKET},
    {"usb", no_argument, NULL, OPTION_USB},
    {"path", required_argument, NULL, OPTION_PATH},
    {"grip", required_argument, NULL, OPTION_GRIP},
    {"ramp-ticks", required_argument, NULL, OPTION_RAMP},
    {"seed", required_argument, NULL, OPTION_SEED},
    {"watchdog-ms", required_argument, NULL, OPTION_WATCHDOG},
    {"scale", required_argument, NULL, OPTION_SCALE},
    {"die-with-parent", no_argument, NULL, OPTION_DIE},
    {"linger-s", required_argument, NULL, OPTION_LINGER},
    {"bus", required_argument, NULL, OPTION_BUS},
    {"serial", required_argument, NULL, OPTION_SERIAL},
    {"devices", required_argument, NULL, OPTION_DEVICES},
    {"timing", required_argument, NULL, OPTION_TIMING},
    {"packets-per-frame", required_argument, NULL, OPTION_PACKETS},
    {"faults", required_argument, NULL, OPTION_FAULTS},
    {"running", no_argument, NULL, OPTION_RUNNING},
    {"zero-before-answer", no_argument, NULL, OPTION_ZERO},
    {"xoff-before-echo", no_argument, NULL, OPTION_XOFF},
    {"autobaud-fail", required_argument, NULL, OPTION_AUTOBAUD},
    {"unplug-keeps-firmware", no_argument, NULL, OPTION_KEEPS},
    {"modem-lines", required_argument, NULL, OPTION_LINES},
    {"home-deg", required_argument, NULL, OPTION_HOME},
    {"listen", required_argument, NULL, OPTION_LISTEN},
    {"port", required_argument, NULL, OPTION_PORT},
    {"device", required_argument, NULL, OPTION_DEVICE},
    {"pcap", required_argument, NULL, OPTION_PCAP},
    {"help", no_argument, NULL, OPTION_HELP},
    {NULL, 0, NULL, 0},
};

/// Which verbs an option belongs to.
static unsigned verbs_of(int id) {
    switch (id) {
        case OPTION_SOCKET:
            return PAL_VERB_SOCKET;
        case OPTION_USB:
            return PAL_VERB_USB;
        case OPTION_PATH:
        case OPTION_GRIP:
        case OPTION_RAMP:
        case OPTION_SEED:
        case OPTION_WATCHDOG:
        case OPTION_SCALE:
            return PAL_VERB_SOCKET | USB_VERBS;
        case OPTION_DIE:
            return PAL_VERB_SOCKET | PAL_VERB_USB | PAL_VERB_USBIP;
        case OPTION_LINGER:
            return PAL_VERB_SOCKET;
        case OPTION_BUS:
            return USB_VERBS | PAL_VERB_ASK;
        case OPTION_LISTEN:
        case OPTION_PORT:
            return PAL_VERB_USBIP;
        case OPTION_DEVICE:
            return PAL_VERB_ASK;
        default:
            return USB_VERBS;
    }
}

static bool read_probability(const char* text, uint32_t* per_million) {
    double p;
    if (!parse_number(text, 0.0, 1.0, &p)) return false;
    *per_million = (uint32_t)(p * 1e6 + 0.5);
    return true;
}

static bool read_lines(const char* text, uint8_t* lines) {
    char* end;
    const unsigned long value = strtoul(text, &end, 16);
    if (end == text || *end != '\0' || (value & ~0xF0UL) != 0) return false;
    *lines = (uint8_t)value;
    return true;
}

static bool is_address(const char* text) {
    struct in_addr address;
    return inet_pton(AF_INET, text, &address) == 1;
}

/// Options for what nobody knows of a real device. NULL, or what would be right.
static const char* take_unknown(int id, const char* value, pal_options* o) {
    pal_loader_config* loader = &o->device.loader;
    double degrees;
    switch (id) {
        case OPTION_RUNNING:
            o->device.running = true;
            return NULL;
        case OPTION_ZERO:
            loader->zero_before_answer = true;
            return NULL;
        case OPTION_XOFF:
            loader->xoff_before_echo = true;
            return NULL;
        case OPTION_KEEPS:
            o->device.unplug_keeps_firmware = true;
            return NULL;
        case OPTION_AUTOBAUD:
            return read_probability(value, &loader->autobaud_fail_per_million)
                       ? NULL
                       : "must be a probability, 0..1";
        case OPTION_LINES:
            return read_lines(value, &o->device.modem_lines) ? NULL
                                                             : "must be the status lines in hex: 10 CTS, 20 "
                                                               "DSR, 40 RI, 80 DCD, or a sum such as 30";
        default:  // OPTION_HOME
            if (!parse_number(value, -23.0, 89.0, &degrees))
                return "must be an arm angle in degrees, -23..89: beyond are the stops";
            o->serve.falcon.home_theta_rad = degrees * (3.14159265358979323846 / 180.0);
            return NULL;
    }
}

/// Options of the devices on USB. NULL, or what would be right.
static const char* take_usb(int id, const char* value, pal_options* o) {
    switch (id) {
        case OPTION_BUS:
            o->bus = value;
            return NULL;
        case OPTION_SERIAL:
            o->serial = value;
            return NULL;
        case OPTION_FAULTS:
            o->faults_file = value;
            return NULL;
        case OPTION_PCAP:
            o->pcap_file = value;
            return NULL;
        case OPTION_LISTEN:
            o->listen = value;
            return is_address(value) ? NULL : "must be an IPv4 address, 127.0.0.1 or 0.0.0.0 for everybody";
        case OPTION_DEVICES:
            return parse_count(value, 1, PAL_BUS_DEVICES_MAX, &o->n_devices) ? NULL
                                                                             : "must be a whole number, 1..8";
        case OPTION_PACKETS:
            return parse_count(value, 1, PAL_HOST_PACKETS_PER_FRAME_MAX, &o->packets_per_frame)
                       ? NULL
                       : "must be a whole number, 1..19";
        case OPTION_TIMING:
            o->timing = strcmp(value, "frames") == 0 ? PAL_HOST_FRAMES : PAL_HOST_IMMEDIATE;
            return strcmp(value, "frames") == 0 || strcmp(value, "immediate") == 0
                       ? NULL
                       : "must be frames (1 ms USB frames, as a real one) or immediate (answers at once)";
        case OPTION_PORT:
            return parse_count(value, 0, TCP_PORT_MAX, &o->tcp_port)
                       ? NULL
                       : "must be a TCP port, 1..65535, or 0 for a free one";
        case OPTION_DEVICE:
            return parse_count(value, 1, PAL_BUS_DEVICES_MAX, &o->device_index)
                       ? NULL
                       : "must be a whole number, 1..8";
        default:
            return take_unknown(id, value, o);
    }
}

/// NULL, or what would be right.
static const char* take(int id, const char* value, pal_options* o) {
    switch (id) {
        case OPTION_SOCKET:
            o->serve.socket_path = value;
            return NULL;
        case OPTION_USB:
            return NULL;
        case OPTION_PATH:
            o->path_file = value;
            return NULL;
        case OPTION_DIE:
            o->serve.die_with_parent = true;
            return NULL;
        case OPTION_GRIP:
            return parse_grip(value, &o->serve.hand)
                       ? NULL
                       : "must be none, light, firm or three numbers like 0.05,150,2";
        case OPTION_RAMP:
            return parse_count(value, 0, TICKS_MAX, &o->ramp_ticks)
                       ? NULL
                       : "must be a whole number of milliseconds, 0..10000000";
        case OPTION_SEED:
            return parse_count(value, 0, UINT64_MAX, &o->seed) ? NULL : "must be a whole number";
        case OPTION_WATCHDOG:
            return parse_count(value, 1, TICKS_MAX, &o->watchdog_ms)
                       ? NULL
                       : "must be a whole number of milliseconds, 1..10000000";
        case OPTION_SCALE:
            return parse_number(value, 0.25, 4.0, &o->scale)
                       ? NULL
                       : "must be how large the delta is, 0.25..4 times a Falcon, such as 1.5";
        case OPTION_LINGER:
            return parse_count(value, 0, LINGER_MAX_S, &o->linger_s)
                       ? NULL
                       : "must be a whole number of seconds, 0..3600";
        default:
            return take_usb(id, value, o);
    }
}

static void set_defaults(pal_options* o) {
    memset(o, 0, sizeof *o);
    o->ramp_ticks = 1000;
    o->scale = 1.0;
    o->seed = 1;
    o->watchdog_ms = 100;
    o->linger_s = 5;
    o->n_devices = 1;
    o->packets_per_frame = 1;
    o->timing = PAL_HOST_FRAMES;
    o->listen = "127.0.0.1";
    o->tcp_port = USBIP_PORT;
    o->device = pal_usb_device_config_default();
    o->serve.falcon = pal_falcon_sim_config_default();
    (void)parse_grip("light", &o->serve.hand);
}

static bool has(int argc, char** argv, const char* option) {
    const size_t n = strlen(option);
    for (int i = 1; i < argc; ++i) {
        if (strncmp(argv[i], option, n) == 0 && (argv[i][n] == '\0' || argv[i][n] == '=')) return true;
    }
    return false;
}

/// The kind of verb: serve, status and quit have two.
static int kind_of(int argc, char** argv, const char* verb, pal_verb* out) {
    const bool usb = has(argc, argv, "--usb");
    const bool socket = has(argc, argv, "--socket");
    if (strcmp(verb, "run") == 0) {
        *out = PAL_VERB_RUN;
    } else if (strcmp(verb, "usbip") == 0) {
        *out = PAL_VERB_USBIP;
    } else if (strcmp(verb, "serve") != 0) {
        *out = socket ? PAL_VERB_SOCKET : PAL_VERB_ASK;
    } else if (usb == socket) {
        return pal_options_refuse(
            "serve", "",
            "needs --usb (any program on libusb sees the device) or --socket PATH (packets alone)");
    } else {
        *out = usb ? PAL_VERB_USB : PAL_VERB_SOCKET;
    }
    return 0;
}

int pal_options_read(int argc, char** argv, const char* verb, pal_options* o) {
    set_defaults(o);
    const int code = kind_of(argc, argv, verb, &o->verb);
    if (code != 0) return code;
    int id;
    optind = 1;
    // Only of run do the words belong to somebody else.
    const char* order = o->verb == PAL_VERB_RUN ? "+h" : "h";
    while ((id = getopt_long(argc, argv, order, known, NULL)) != -1) {
        if (id == 'h' || id == OPTION_HELP) {
            o->help = true;
            return 0;
        }
        if (id <= 0 || id >= N_OPTIONS) return PAL_EXIT_BAD_INPUT;  // getopt_long has said which
        const char* name = "";
        for (size_t i = 0; known[i].name; ++i) {
            if (known[i].val == id) name = known[i].name;
        }
        char option[64];
        (void)snprintf(option, sizeof option, "--%s", name);
        const char* value = optarg ? optarg : "";
        if ((verbs_of(id) & (unsigned)o->verb) == 0) {
            return pal_options_refuse(option, value,
                                      "does not belong here; palpate-falcon-sim --help says where");
        }
        const char* right = take(id, value, o);
        if (right) return pal_options_refuse(option, value, right);
    }
    o->rest = argv + optind;
    return 0;
}

const char* pal_options_bus(const pal_options* o) {
    static char usual[64];
    if (o->bus) return o->bus;
    const char* from_environment = getenv(PAL_BUS_VARIABLE);
    if (from_environment && from_environment[0] != '\0') return from_environment;
    (void)snprintf(usual, sizeof usual, "/tmp/palpate-falcon-%u", (unsigned)getuid());
    return usual;
}
