#include "firmware/port/linux/disturbance.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { PATH_BYTES = 64, TEXT_BYTES = 2048, MINOR_AT = 8, MAJOR_AT = 10 };

static int open_file(int tid, const char* name) {
    char path[PATH_BYTES];
    (void)snprintf(path, sizeof path, "/proc/self/task/%d/%s", tid, name);
    return open(path, O_RDONLY | O_CLOEXEC);
}

static bool read_text(int file, char text[TEXT_BYTES]) {
    const ssize_t n_bytes = pread(file, text, TEXT_BYTES - 1, 0);
    if (n_bytes <= 0) return false;
    text[n_bytes] = '\0';
    return true;
}

// proc(5): fields after the command's closing bracket; `at` counts them from 1.
static uint32_t stat_field(const char* text, int at) {
    const char* field = strrchr(text, ')');
    for (int i = 0; field != NULL && i < at; ++i) field = strchr(field + 1, ' ');
    return field != NULL ? (uint32_t)strtoul(field, NULL, 10) : 0U;
}

static bool read_counts(const pal_disturbance* self, pal_disturbance_counts* counts) {
    static const char PREEMPTED[] = "nonvoluntary_ctxt_switches:";
    char text[TEXT_BYTES];
    if (!read_text(self->stat_file, text)) return false;
    counts->n_minor_faults = stat_field(text, MINOR_AT);
    counts->n_major_faults = stat_field(text, MAJOR_AT);
    if (!read_text(self->status_file, text)) return false;
    const char* line = strstr(text, PREEMPTED);
    if (line == NULL) return false;
    counts->n_preempted = (uint32_t)strtoul(line + sizeof PREEMPTED - 1, NULL, 10);
    return true;
}

bool pal_disturbance_open(pal_disturbance* self, int tid) {
    *self = (pal_disturbance){.stat_file = open_file(tid, "stat"), .status_file = open_file(tid, "status")};
    if (read_counts(self, &self->start)) return true;
    pal_disturbance_close(self);
    return false;
}

bool pal_disturbance_read(const pal_disturbance* self, pal_disturbance_counts* counts) {
    if (!read_counts(self, counts)) return false;
    counts->n_minor_faults -= self->start.n_minor_faults;
    counts->n_major_faults -= self->start.n_major_faults;
    counts->n_preempted -= self->start.n_preempted;
    return true;
}

void pal_disturbance_close(pal_disturbance* self) {
    if (self->stat_file >= 0) (void)close(self->stat_file);
    if (self->status_file >= 0) (void)close(self->status_file);
    *self = (pal_disturbance){.stat_file = -1, .status_file = -1};
}
