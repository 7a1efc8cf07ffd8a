#include "sim/app/ask.h"

#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "sim/app/exit_codes.h"
#include "sim/app/local_socket.h"

enum { ANSWER_BYTES = 16384 };

int pal_ask(const char* path, const char* question, const char* start) {
    static const char refusal[] = "{\"error\":";
    char answer[ANSWER_BYTES];
    ssize_t got = -1;
    const int fd = pal_socket_connect(path);
    if (fd >= 0) {
        if (send(fd, question, strlen(question), MSG_NOSIGNAL) > 0) got = recv(fd, answer, sizeof answer, 0);
        (void)close(fd);
    }
    if (got <= 0) {
        (void)fprintf(stderr, "palpate-falcon-sim: %s: nobody answers; start one with %s\n", path, start);
        return PAL_EXIT_LINK;
    }
    if (fwrite(answer, 1, (size_t)got, stdout) != (size_t)got) return 1;
    const size_t n = sizeof refusal - 1;
    return (size_t)got >= n && memcmp(answer, refusal, n) == 0 ? PAL_EXIT_BAD_INPUT : 0;
}
