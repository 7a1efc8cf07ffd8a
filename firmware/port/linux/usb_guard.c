#include "firmware/port/linux/usb_guard.h"

#include <errno.h>
#include <signal.h>
#include <spawn.h>
#include <stddef.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

extern char** environ;

enum { WORDS = 6 };

static int spawn(pid_t* process, const char* program, const char* serial, int stdin_file) {
    char* const words[WORDS] = {(char*)program,         (char*)"zero",
                                (char*)"--after-stdin", serial[0] != '\0' ? (char*)"--serial" : NULL,
                                (char*)serial,          NULL};
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    (void)posix_spawn_file_actions_init(&actions);
    (void)posix_spawn_file_actions_adddup2(&actions, stdin_file, STDIN_FILENO);
    (void)posix_spawnattr_init(&attributes);
    (void)posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
    const int error = posix_spawn(process, program, &actions, &attributes, words, environ);
    (void)posix_spawnattr_destroy(&attributes);
    (void)posix_spawn_file_actions_destroy(&actions);
    return error;
}

bool pal_usb_guard_start(pal_usb_guard* guard, const char* program, const char* serial) {
    int ends[2];
    pid_t process = 0;
    *guard = (pal_usb_guard){.file = -1};
    // Not a pipe: the farewell to a guard that has died must not end the loop by SIGPIPE.
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return false;
    const int error = spawn(&process, program, serial, ends[0]);
    (void)close(ends[0]);
    if (error != 0) {
        (void)close(ends[1]);
        errno = error;
        return false;
    }
    *guard = (pal_usb_guard){.file = ends[1], .process = (int)process};
    return true;
}

bool pal_usb_guard_is_needed(void) {
    for (;;) {
        char byte = 0;
        const ssize_t n = read(STDIN_FILENO, &byte, 1);
        if (n == 1 && byte == PAL_USB_GUARD_FAREWELL) return false;
        if (n == 0 || (n < 0 && errno != EINTR)) return true;
    }
}

void pal_usb_guard_dismiss(pal_usb_guard* guard) {
    if (guard->file < 0) return;
    const char farewell = PAL_USB_GUARD_FAREWELL;
    const struct timespec pause = {.tv_nsec = 1000000};
    (void)send(guard->file, &farewell, 1, MSG_NOSIGNAL);
    (void)close(guard->file);
    guard->file = -1;
    for (int ms = 0; ms < PAL_USB_GUARD_END_MS && waitpid((pid_t)guard->process, NULL, WNOHANG) == 0; ++ms) {
        (void)nanosleep(&pause, NULL);
    }
}
