#include "sim/app/signals.h"

#include <signal.h>
#include <stddef.h>
#include <sys/signalfd.h>

int pal_signals_open(void) {
    static const int all[] = {SIGTERM, SIGINT, SIGHUP};
    sigset_t ends;
    (void)sigemptyset(&ends);
    for (size_t i = 0; i < sizeof all / sizeof all[0]; ++i) {
        struct sigaction now;
        if (sigaction(all[i], NULL, &now) != 0) return -1;
        // Of a blocked signal the kernel forgets that it was to be ignored, by nohup or a shell's "&".
        if (now.sa_handler != SIG_IGN) (void)sigaddset(&ends, all[i]);
    }
    if (sigprocmask(SIG_BLOCK, &ends, NULL) != 0) return -1;
    return signalfd(-1, &ends, SFD_CLOEXEC | SFD_NONBLOCK);
}
