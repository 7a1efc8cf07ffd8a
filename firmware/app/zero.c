#include "firmware/app/zero.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

#include "firmware/app/takeover.h"
#include "firmware/port/linux/clock_loop.h"
#include "firmware/port/linux/device_socket.h"

enum { EXIT_DONE = 0, EXIT_DEVICE = 3, TRIES_MAX = 200, RETRY_TICKS = 5 };

static const uint64_t TICK_NS = 1000000U;

static pal_takeover_end take_over(const pal_device* device, pal_clock_loop* clock) {
    pal_takeover takeover = {.n_ticks = 0};
    pal_takeover_end end = pal_takeover_tick(&takeover, device);
    while (end == PAL_TAKEOVER_RUNS) {
        (void)pal_clock_loop_wait(clock);
        end = pal_takeover_tick(&takeover, device);
    }
    return end;
}

static int zero_socket(const char* path) {
    pal_takeover_end how = PAL_TAKEOVER_HUNG_UP;
    pal_clock_loop clock;
    pal_clock_loop_start(&clock, TICK_NS);
    for (int n = 0; n < TRIES_MAX && how == PAL_TAKEOVER_HUNG_UP; ++n) {
        pal_device_socket socket;
        pal_device device;
        const pal_err err = pal_device_socket_open(&socket, path, &device);
        if (err != PAL_OK) {
            (void)fprintf(stderr, "palpate-loop: --device link:%s: %s\n", path,
                          err == PAL_ERR_IO ? strerror(errno) : "path too long for a socket");
            return EXIT_DEVICE;
        }
        how = take_over(&device, &clock);
        pal_device_socket_close(&socket);
        for (int i = 0; i < RETRY_TICKS && how == PAL_TAKEOVER_HUNG_UP; ++i)
            (void)pal_clock_loop_wait(&clock);
    }
    if (how == PAL_TAKEOVER_DONE) return EXIT_DONE;
    (void)fprintf(
        stderr, "palpate-loop: --device link:%s: %s\n", path,
        how == PAL_TAKEOVER_SILENT ? "the device does not answer" : "another program holds the device");
    return EXIT_DEVICE;
}

bool pal_loop_program_beside(const char* name, char path[PAL_LOOP_PATH_BYTES]) {
    const size_t n_name = strlen(name) + 1;
    if (n_name >= PAL_LOOP_PATH_BYTES) return false;
    const ssize_t n = readlink("/proc/self/exe", path, PAL_LOOP_PATH_BYTES - n_name);
    if (n <= 0) return false;
    path[n] = '\0';
    char* last = strrchr(path, '/');
    if (last == NULL) return false;
    memcpy(last + 1, name, n_name);
    return true;
}

static int zero_usb(const char* serial) {
    char path[PAL_LOOP_PATH_BYTES] = "palpate-falcon";
    if (pal_loop_program_beside("palpate-falcon", path)) {
        const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
        if (nowhere >= 0) (void)dup2(nowhere, STDOUT_FILENO);  // its word of success
        char* const words[] = {path, (char*)"zero", serial != NULL ? (char*)"--serial" : NULL, (char*)serial,
                               NULL};
        (void)execv(path, words);
    }
    (void)fprintf(stderr, "palpate-loop: %s: %s\n", path, strerror(errno));
    return EXIT_DEVICE;
}

int pal_loop_zero(const pal_loop_options* options) {
    return options->usb ? zero_usb(options->serial) : zero_socket(options->device_path);
}
