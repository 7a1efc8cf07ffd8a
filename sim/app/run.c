#include "sim/app/run.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "sim/app/usb_serve.h"
#include "sim/usb/preload_wire.h"
#include "sim/usb/usbfs_tree.h"

enum {
    START_MS = 10000,
    END_MS = 2000,
    POLL_MS = 5,
    EXIT_CANNOT_RUN = 126,
    EXIT_NOT_FOUND = 127,
    EXIT_SIGNAL = 128
};

static const char LIBRARY[] = "libpalpate-falcon-preload.so";

/// Path of the preload library: beside this program, or in the lib folder next to its folder.
static bool find_library(char out[PATH_MAX]) {
    static const char* const places[] = {"", "../lib/", "../lib/palpate/"};
    char self[PATH_MAX];
    const ssize_t n = readlink("/proc/self/exe", self, sizeof self - 1);
    self[n > 0 ? n : 0] = '\0';
    if (n <= 0) {
        (void)fprintf(stderr, "palpate-falcon-sim: /proc/self/exe: %s; /proc must be there\n",
                      strerror(errno));
        return false;
    }
    *(strrchr(self, '/') + 1) = '\0';
    for (size_t i = 0; i < sizeof places / sizeof places[0]; ++i) {
        const int length = snprintf(out, PATH_MAX, "%s%s%s", self, places[i], LIBRARY);
        if (length <= 0 || length >= PATH_MAX || access(out, R_OK) != 0) continue;
        if (!strpbrk(out, " :\t\n")) return true;
        (void)fprintf(
            stderr,
            "palpate-falcon-sim: %s: LD_PRELOAD cannot name it; install it in a folder without spaces and "
            "colons\n",
            out);
        return false;
    }
    (void)fprintf(
        stderr,
        "palpate-falcon-sim: %s is not beside this program (%s) nor in ../lib; build or install it there\n",
        LIBRARY, self);
    return false;
}

/// `variable` becomes "old:value", or `value` when it was not set; where it has `value` already it stays.
static bool extend(const char* variable, const char* value) {
    const char* old = getenv(variable);
    if (!old || old[0] == '\0') return setenv(variable, value, 1) == 0;
    if (strstr(old, value)) return true;
    const size_t n = strlen(old) + strlen(value) + 2;
    char* both = malloc(n);
    if (!both) return false;
    (void)snprintf(both, n, "%s:%s", old, value);
    const bool good = setenv(variable, both, 1) == 0;
    free(both);
    return good;
}

/// Programs and shells may go to other folders: the bus by its whole path. False: words on stderr.
static bool whole_path(const char* folder, char out[PATH_MAX]) {
    const bool found = realpath(folder, out) != NULL;
    if (found && strlen(out) <= PAL_TREE_FOLDER_MAX) return true;
    (void)fprintf(stderr,
                  "palpate-falcon-sim: %s: %s; name a bus folder whose whole path has at most %d bytes, e.g. "
                  "/tmp/falcon\n",
                  found ? out : folder, found ? "too long" : strerror(errno), PAL_TREE_FOLDER_MAX);
    return false;
}

/// For a POSIX shell.
static void print_export(const char* variable, const char* value) {
    (void)printf("export %s='", variable);
    for (; *value != '\0'; ++value) {
        if (*value == '\'') (void)fputs("'\\'", stdout);
        (void)putchar(*value);
    }
    (void)puts("'");
}

int pal_env(const char* folder) {
    char library[PATH_MAX];
    if (!find_library(library)) return PAL_EXIT_LINK;
    if (!pal_tree_is_served(folder)) {
        (void)fprintf(stderr,
                      "palpate-falcon-sim: %s: nobody serves it; start one with serve --usb --bus %s\n",
                      folder, folder);
        return PAL_EXIT_LINK;
    }
    char whole[PATH_MAX];
    if (!whole_path(folder, whole) || !extend("LD_PRELOAD", library)) return PAL_EXIT_LINK;
    print_export(PAL_BUS_VARIABLE, whole);
    print_export("LD_PRELOAD", getenv("LD_PRELOAD"));
    return fflush(stdout) == 0 ? 0 : PAL_EXIT_LINK;
}

// The two children.

static pid_t start_simulator(pal_options* o, const char* folder, int ready[2]) {
    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child != 0) return child;
    // A group of its own: Ctrl-C is for the program, which may have a last zero force to send.
    (void)setpgid(0, 0);
    (void)prctl(PR_SET_PDEATHSIG, SIGTERM);
    (void)close(ready[0]);
    if (getppid() != parent) _exit(PAL_EXIT_LINK);
    const int code = pal_usb_serve(o, folder, ready[1]);
    (void)fflush(NULL);
    _exit(code);
}

static pid_t start_program(char** argv, const char* folder, const char* library) {
    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child != 0) return child;
    (void)prctl(PR_SET_PDEATHSIG, SIGTERM);  // who kills this process wants its program to end
    if (getppid() != parent) _exit(PAL_EXIT_LINK);
    sigset_t none;
    (void)sigemptyset(&none);
    (void)sigprocmask(SIG_SETMASK, &none, NULL);
    (void)prctl(PR_SET_TIMERSLACK, 1UL);  // a loop at 1 kHz wakes when it asked to
    // Programs under the address sanitizer must not insist on being the first library.
    if (setenv(PAL_BUS_VARIABLE, folder, 1) == 0 && extend("LD_PRELOAD", library) &&
        extend("ASAN_OPTIONS", "verify_asan_link_order=0")) {
        (void)execvp(argv[0], argv);
    }
    const int reason = errno;
    (void)fprintf(stderr, "palpate-falcon-sim: %s: %s; name a program after --\n", argv[0], strerror(reason));
    _exit(reason == ENOENT ? EXIT_NOT_FOUND : EXIT_CANNOT_RUN);
}

static int code_of(int status) {
    return WIFEXITED(status) ? WEXITSTATUS(status) : EXIT_SIGNAL + WTERMSIG(status);
}

/// Waits for the simulator's one byte. 0, or the exit code when it ended instead.
static int wait_ready(pid_t simulator, int fd) {
    struct pollfd news = {.fd = fd, .events = POLLIN};
    char byte;
    int n;
    do n = poll(&news, 1, START_MS);
    while (n < 0 && errno == EINTR);
    if (n > 0 && read(fd, &byte, 1) == 1) return 0;
    if (n == 0) {
        (void)fprintf(stderr, "palpate-falcon-sim: the simulator did not start within 10 s\n");
        (void)kill(simulator, SIGKILL);
    }
    int status = 0;
    (void)waitpid(simulator, &status, 0);
    return n > 0 && WIFEXITED(status) && WEXITSTATUS(status) != 0 ? WEXITSTATUS(status) : PAL_EXIT_LINK;
}

/// Ends the simulator: asks, and kills it when it does not listen.
static void end_simulator(pid_t simulator) {
    (void)kill(simulator, SIGTERM);
    for (int waited_ms = 0; waited_ms < END_MS; waited_ms += POLL_MS) {
        const pid_t ended = waitpid(simulator, NULL, WNOHANG);
        if (ended == simulator || (ended < 0 && errno == ECHILD)) return;
        const struct timespec pause = {0, POLL_MS * 1000000L};
        (void)nanosleep(&pause, NULL);
    }
    (void)kill(simulator, SIGKILL);
    (void)waitpid(simulator, NULL, 0);
}

/// Waits for the program; passes SIGTERM and SIGHUP on. SIGINT and SIGQUIT reach it from the terminal by
/// themselves.
static int wait_program(pid_t program, pid_t* simulator, const sigset_t* wanted) {
    for (;;) {
        int status;
        pid_t ended;
        while ((ended = waitpid(-1, &status, WNOHANG)) > 0) {
            if (ended == program) return code_of(status);
            if (ended == *simulator) {
                *simulator = -1;
                (void)fprintf(stderr,
                              "palpate-falcon-sim: the simulator ended before the program; to that, it was "
                              "unplugged\n");
            }
        }
        const int signal_number = sigwaitinfo(wanted, NULL);
        if (signal_number == SIGTERM || signal_number == SIGHUP) (void)kill(program, signal_number);
    }
}

static bool make_folder(const pal_options* o, char out[PAL_TREE_PATH_BYTES]) {
    if (o->bus) {
        (void)snprintf(out, PAL_TREE_PATH_BYTES, "%s", o->bus);
        return true;
    }
    (void)snprintf(out, PAL_TREE_PATH_BYTES, "/tmp/palpate-falcon-XXXXXX");
    return mkdtemp(out) != NULL;
}

static int run_program(pal_options* o, pid_t simulator, const char* folder, const char* library,
                       const sigset_t* wanted) {
    char whole[PATH_MAX];
    int code = PAL_EXIT_LINK;
    const bool reachable = whole_path(folder, whole);
    const pid_t program = reachable ? start_program(o->rest, whole, library) : -1;
    if (program > 0) {
        code = wait_program(program, &simulator, wanted);
    } else if (reachable) {
        (void)fprintf(stderr, "palpate-falcon-sim: no process for the program: %s\n", strerror(errno));
    }
    if (simulator > 0) end_simulator(simulator);
    return code;
}

int pal_run(pal_options* o) {
    char library[PATH_MAX];
    char folder[PAL_TREE_PATH_BYTES];
    int ready[2];
    if (!o->rest[0]) {
        return pal_options_refuse("run", "",
                                  "needs a program: palpate-falcon-sim run [options] -- PROGRAM [arguments]");
    }
    if (!find_library(library)) return PAL_EXIT_LINK;
    if (!make_folder(o, folder) || pipe2(ready, O_CLOEXEC) != 0) {
        (void)fprintf(stderr, "palpate-falcon-sim: no bus folder: %s; name one with --bus\n",
                      strerror(errno));
        return PAL_EXIT_LINK;
    }
    sigset_t wanted;
    (void)sigemptyset(&wanted);
    (void)sigaddset(&wanted, SIGCHLD);
    (void)sigaddset(&wanted, SIGTERM);
    (void)sigaddset(&wanted, SIGHUP);
    (void)sigaddset(&wanted, SIGINT);
    (void)sigaddset(&wanted, SIGQUIT);
    (void)sigprocmask(SIG_BLOCK, &wanted, NULL);
    const pid_t simulator = start_simulator(o, folder, ready);
    (void)close(ready[1]);
    int code = PAL_EXIT_LINK;
    if (simulator > 0) {
        code = wait_ready(simulator, ready[0]);
        if (code == 0) code = run_program(o, simulator, folder, library, &wanted);
    }
    (void)close(ready[0]);
    if (!pal_tree_is_served(folder)) pal_tree_clear(folder);  // what a killed simulator left
    if (!o->bus) (void)rmdir(folder);
    return code;
}
