/// palpate-falcon-sim: a Novint Falcon without a Falcon, held by a hand.
#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim/app/path_file.h"
#include "sim/app/serve.h"

enum { EXIT_BAD_INPUT = 2, TICKS_MAX = 10000000, LINGER_MAX_S = 3600, TICKS_PER_S = 1000 };

static const char HELP[] =
    "palpate-falcon-sim: a simulated Novint Falcon in real time, held by a simulated hand.\n"
    "\n"
    "  palpate-falcon-sim serve --socket PATH [options]   be the device until quit or SIGTERM\n"
    "  palpate-falcon-sim status --socket PATH            print one line of JSON: motors, position, state\n"
    "  palpate-falcon-sim quit --socket PATH              end the one that serves PATH\n"
    "\n"
    "Options of serve:\n"
    "  --socket PATH       Unix SOCK_SEQPACKET socket: 16 bytes in, 16 bytes out, as a Falcon's "
    "(docs/PROTOCOL.md)\n"
    "                      questions go to PATH.control: \"status\" and \"quit\"\n"
    "  --path FILE         where the hand goes: \"palpate-path 1\", then lines \"t_us x_um y_um z_um\" "
    "(device frame);\n"
    "                      without it the hand homes the device and holds it at the middle\n"
    "  --grip NAME         none, light, firm, or MASS,STIFFNESS,DAMPING in kg, N/m, N s/m; light\n"
    "                      without stiffness a helper homes the device and lets go when the path begins\n"
    "  --ramp-ticks N      milliseconds between homing and the path's start, for the loop's soft start and "
    "the way there;\n"
    "                      give palpate-loop the same; 1000\n"
    "  --seed N            what the counters read before homing; 1\n"
    "  --watchdog-ms N     motors off after so long without a packet; 100\n"
    "  --die-with-parent   end when the process that started this one has ended ...\n"
    "  --linger-s N        ... and N more seconds, in which it can still be asked for its status; 5\n"
    "\n"
    "Exit codes: 0 done, 2 bad input, 3 the socket failed.\n"
    "\n"
    "Example:\n"
    "  palpate-falcon-sim serve --socket /tmp/falcon --grip firm &\n"
    "  palpate-falcon-sim status --socket /tmp/falcon\n";

static int refuse(const char* option, const char* value, const char* right) {
    (void)fprintf(stderr, "palpate-falcon-sim: %s %s: %s\n", option, value, right);
    return EXIT_BAD_INPUT;
}

static bool parse_count(const char* text, unsigned long long max, unsigned long long* out) {
    char* end;
    errno = 0;
    *out = strtoull(text, &end, 10);
    return end != text && *end == '\0' && errno == 0 && text[0] != '-' && *out <= max;
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

typedef struct arguments {
    const char* path_file;
    unsigned long long ramp_ticks, seed, watchdog_ms, linger_s;
    pal_serve_options serve;
} arguments;

static int parse_options(int argc, char** argv, arguments* args) {
    static const struct option known[] = {
        {"socket", required_argument, NULL, 's'},
        {"path", required_argument, NULL, 'p'},
        {"grip", required_argument, NULL, 'g'},
        {"ramp-ticks", required_argument, NULL, 'r'},
        {"seed", required_argument, NULL, 'e'},
        {"watchdog-ms", required_argument, NULL, 'w'},
        {"die-with-parent", no_argument, NULL, 'd'},
        {"linger-s", required_argument, NULL, 'l'},
        {NULL, 0, NULL, 0},
    };
    int option;
    while ((option = getopt_long(argc, argv, "", known, NULL)) != -1) {
        if (option == 's') {
            args->serve.socket_path = optarg;
        } else if (option == 'p') {
            args->path_file = optarg;
        } else if (option == 'g') {
            if (!parse_grip(optarg, &args->serve.hand)) {
                return refuse("--grip", optarg, "must be none, light, firm or three numbers like 0.05,150,2");
            }
        } else if (option == 'r') {
            if (!parse_count(optarg, TICKS_MAX, &args->ramp_ticks)) {
                return refuse("--ramp-ticks", optarg, "must be a whole number of milliseconds, 0..10000000");
            }
        } else if (option == 'e') {
            if (!parse_count(optarg, UINT64_MAX, &args->seed))
                return refuse("--seed", optarg, "must be a whole number");
        } else if (option == 'w') {
            if (!parse_count(optarg, TICKS_MAX, &args->watchdog_ms) || args->watchdog_ms == 0) {
                return refuse("--watchdog-ms", optarg, "must be a whole number of milliseconds, 1..10000000");
            }
        } else if (option == 'l') {
            if (!parse_count(optarg, LINGER_MAX_S, &args->linger_s)) {
                return refuse("--linger-s", optarg, "must be a whole number of seconds, 0..3600");
            }
        } else if (option == 'd') {
            args->serve.die_with_parent = true;
        } else {
            return EXIT_BAD_INPUT;  // getopt_long has said which
        }
    }
    if (optind < argc) return refuse("argument", argv[optind], "not known here; see --help");
    if (!args->serve.socket_path)
        return refuse("--socket", "", "is missing; name the socket, e.g. --socket /tmp/falcon");
    return 0;
}

static int serve(arguments* args) {
    static const pal_hand_point middle = {0.0, {0.0, 0.0, 0.12}};
    pal_falcon_sim_config* falcon = &args->serve.falcon;
    pal_hand_config* hand = &args->serve.hand;
    pal_path_file path = {NULL, 0};
    if (args->path_file) {
        char why[512];
        if (!pal_path_file_read(args->path_file, &path, why, sizeof why)) {
            (void)fprintf(stderr, "palpate-falcon-sim: %s\n", why);
            return EXIT_BAD_INPUT;
        }
    }
    hand->path = path.points ? path.points : &middle;
    hand->n_points = path.points ? path.n_points : 1;
    hand->wait_ticks = (uint32_t)args->ramp_ticks;
    falcon->watchdog_ticks = (uint32_t)args->watchdog_ms;
    if (hand->stiffness_n_per_m > 0.0) hand->weight_n = falcon->mass_kg * falcon->gravity_m_per_s2;
    pal_falcon_sim_seed(falcon, args->seed);
    args->serve.linger_ticks = (uint32_t)args->linger_s * TICKS_PER_S;
    const int code = pal_serve(&args->serve);
    free(path.points);
    return code;
}

int main(int argc, char** argv) {
    arguments args = {.ramp_ticks = 1000, .seed = 1, .watchdog_ms = 100, .linger_s = 5};
    args.serve.falcon = pal_falcon_sim_config_default();
    args.serve.hand.home_in_m[2] = PAL_HAND_HOME_IN_Z_M;
    (void)parse_grip("light", &args.serve.hand);
    for (int i = 1; i < argc; ++i) {
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) return fputs(HELP, stdout) < 0;
    }
    const char* verb = argc > 1 ? argv[1] : "";
    const bool is_serve = strcmp(verb, "serve") == 0;
    if (!is_serve && strcmp(verb, "status") != 0 && strcmp(verb, "quit") != 0) {
        (void)fputs(HELP, stderr);
        return EXIT_BAD_INPUT;
    }
    const int code = parse_options(argc - 1, argv + 1, &args);
    if (code != 0) return code;
    return is_serve ? serve(&args) : pal_serve_ask(args.serve.socket_path, verb);
}
