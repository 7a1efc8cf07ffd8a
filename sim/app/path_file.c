#include "sim/app/path_file.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LINE_MAX_BYTES = 160, N_POINTS_MAX = 1000000, NUMBERS = 4 };
static const long long REACH_MAX_UM = 1000000, TIME_MAX_US = 1000000000000;

typedef struct reader {
    const char* file;
    unsigned line;
    char* why;
    size_t n_why;
} reader;

__attribute__((format(printf, 2, 3))) static bool refuse(const reader* r, const char* format, ...) {
    int n = snprintf(r->why, r->n_why, "%s:%u: ", r->file, r->line);
    if (n < 0 || (size_t)n >= r->n_why) return false;
    va_list values;
    va_start(values, format);
    (void)vsnprintf(r->why + n, r->n_why - (size_t)n, format, values);
    va_end(values);
    return false;
}

static bool parse_line(const reader* r, const char* text, long long number[NUMBERS]) {
    const char* at = text;
    for (int i = 0; i < NUMBERS; ++i) {
        char* end;
        errno = 0;
        number[i] = strtoll(at, &end, 10);
        if (end == at || errno != 0 || !strchr(" \t\r\n", *end)) {
            return refuse(
                r, "not four whole numbers; a point is \"t_us x_um y_um z_um\", e.g. 1500000 0 -2000 118000");
        }
        at = end;
    }
    if (at[strspn(at, " \t\r\n")] != '\0') {
        return refuse(r, "more than four numbers; a point is \"t_us x_um y_um z_um\"");
    }
    return true;
}

static bool check_point(const reader* r, const long long number[NUMBERS], const pal_path_file* so_far) {
    if (number[0] < 0 || number[0] > TIME_MAX_US) {
        return refuse(r, "time %lld us; it must lie in 0..%lld", number[0], TIME_MAX_US);
    }
    const double t_s = (double)number[0] * 1e-6;
    if (so_far->n_points > 0 && !(t_s > so_far->points[so_far->n_points - 1].t_s)) {
        return refuse(r, "time %lld us is not after the line before; times must increase", number[0]);
    }
    for (int i = 1; i < NUMBERS; ++i) {
        if (number[i] < -REACH_MAX_UM || number[i] > REACH_MAX_UM) {
            return refuse(r, "%c is %lld um; a Falcon reaches about 100000 um, the limit is %lld", "txyz"[i],
                          number[i], REACH_MAX_UM);
        }
    }
    return true;
}

static bool append(const reader* r, const long long number[NUMBERS], pal_path_file* out, uint32_t* n_room) {
    if (out->n_points == N_POINTS_MAX)
        return refuse(r, "more than %d points; thin the path out", N_POINTS_MAX);
    if (out->n_points == *n_room) {
        *n_room = *n_room == 0 ? 1024 : 2 * *n_room;
        pal_hand_point* more = realloc(out->points, *n_room * sizeof *more);
        if (!more) return refuse(r, "no memory for the path");
        out->points = more;
    }
    pal_hand_point* point = &out->points[out->n_points++];
    point->t_s = (double)number[0] * 1e-6;
    for (int i = 0; i < 3; ++i) point->at_m[i] = (double)number[i + 1] * 1e-6;
    return true;
}

static bool read_points(FILE* in, reader* r, pal_path_file* out) {
    static const char header[] = "palpate-path 1";
    char text[LINE_MAX_BYTES];
    uint32_t n_room = 0;
    while (fgets(text, sizeof text, in)) {
        ++r->line;
        if (strlen(text) + 1 == sizeof text)
            return refuse(r, "line too long; a point is \"t_us x_um y_um z_um\"");
        if (r->line == 1) {
            text[strcspn(text, "\r\n")] = '\0';
            if (strcmp(text, header) != 0)
                return refuse(r, "not a path; the first line must be \"%s\"", header);
            continue;
        }
        if (text[strspn(text, " \t\r\n")] == '\0') continue;
        long long number[NUMBERS];
        if (!parse_line(r, text, number) || !check_point(r, number, out) ||
            !append(r, number, out, &n_room)) {
            return false;
        }
    }
    if (ferror(in)) return refuse(r, "cannot be read: %s; it must be a text file", strerror(errno));
    ++r->line;
    if (r->line == 1) return refuse(r, "empty; the first line must be \"%s\"", header);
    if (out->n_points == 0)
        return refuse(r, "no points; at least one line \"t_us x_um y_um z_um\" must follow");
    return true;
}

bool pal_path_file_read(const char* file, pal_path_file* out, char* why, size_t n_why) {
    reader r = {file, 0, why, n_why};
    memset(out, 0, sizeof *out);
    FILE* in = fopen(file, "r");
    if (!in) return refuse(&r, "%s; name a readable file", strerror(errno));
    const bool good = read_points(in, &r, out);
    (void)fclose(in);
    if (!good) {
        free(out->points);
        memset(out, 0, sizeof *out);
    }
    return good;
}
