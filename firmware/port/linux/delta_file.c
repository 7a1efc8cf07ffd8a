#include "firmware/port/linux/delta_file.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "common/frame.h"
#include "firmware/port/linux/regular_file.h"
#include "firmware/port/linux/toml_text.h"

static const float RAD_PER_DEG = 0.0174532925F;  // as in nf1.c: the same product has the same bits
static const float SAME_PLACE_M = 1.0e-5F;
enum { AXES = 3, SHOWN_CHARS_MAX = 40, KEY_CHARS_MAX = 31, SEARCH_STEPS = 12 };

typedef enum key {
    ARM,
    FOREARM,
    OFFSET,
    PLATFORM_U,
    PLATFORM_V,
    BASE_U,
    BASE_V,
    LEGS,
    COUNTS_PER_RAD,
    THETA_ZERO,
    THETA_MIN,
    THETA_MAX,
    UNITS_PER_N_M,
    MOTOR_MAX,
    CENTRE,
    N_KEYS
} key;

static const struct {
    const char* name;
    float low, high;
    int n;  ///< numbers
} KEYS[N_KEYS] = {
    [ARM] = {"arm_m", 0.005F, 1.0F, 1},
    [FOREARM] = {"forearm_m", 0.005F, 2.0F, 1},
    [OFFSET] = {"offset_m", 0.0F, 1.0F, 1},
    [PLATFORM_U] = {"platform_u_m", -1.0F, 1.0F, 1},
    [PLATFORM_V] = {"platform_v_m", -1.0F, 1.0F, 1},
    [BASE_U] = {"base_u_m", -1.0F, 1.0F, 1},
    [BASE_V] = {"base_v_m", -1.0F, 1.0F, 1},
    [LEGS] = {"leg_deg", -360.0F, 360.0F, AXES},
    [COUNTS_PER_RAD] = {"counts_per_rad", 1.0F, 1.0e6F, 1},
    [THETA_ZERO] = {"theta_zero_deg", -180.0F, 180.0F, 1},
    [THETA_MIN] = {"theta_min_deg", -180.0F, 180.0F, 1},
    [THETA_MAX] = {"theta_max_deg", -180.0F, 180.0F, 1},
    [UNITS_PER_N_M] = {"units_per_n_m", 1.0F, 1.0e6F, 1},
    [MOTOR_MAX] = {"motor_max_units", 1.0F, 32767.0F, 1},
    [CENTRE] = {"centre_m", -3.0F, 3.0F, AXES},
};

typedef struct reader {
    const char* name;
    const char* at;
    const char* end;
    uint32_t line;
    char* why;
    float values[N_KEYS][AXES];
    uint32_t line_of[N_KEYS];  ///< 0: not seen yet
} reader;

__attribute__((format(printf, 3, 4))) static bool refuse(const reader* r, uint32_t line, const char* format,
                                                         ...) {
    const int n = line > 0 ? snprintf(r->why, PAL_DELTA_WORDS_BYTES, "%.400s:%u: ", r->name, line)
                           : snprintf(r->why, PAL_DELTA_WORDS_BYTES, "%.400s: ", r->name);
    const size_t n_head = n > 0 && n < PAL_DELTA_WORDS_BYTES ? (size_t)n : 0;
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(r->why + n_head, PAL_DELTA_WORDS_BYTES - n_head, format, arguments);
    va_end(arguments);
    for (char* c = r->why; *c != '\0'; ++c) {  // one line, whatever stands in the file or its name
        if ((unsigned char)*c < 0x20 || *c == 0x7F) *c = '?';
    }
    return false;
}

// ---- characters

static bool is_key_char(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
}

// What TOML takes as text at all.
static bool check_text(const reader* r) {
    uint32_t line = 1;
    uint8_t byte = 0;
    switch (pal_toml_check_text(r->at, (size_t)(r->end - r->at), &line, &byte)) {
        case PAL_TOML_TEXT:
            break;
        case PAL_TOML_NOT_UTF8:
            return refuse(r, line, "byte %02X is no UTF-8; expected a file saved as UTF-8", byte);
        case PAL_TOML_CONTROL:
            return refuse(r, line, "control character %02X; expected text whose lines end with LF or CR LF",
                          byte);
    }
    return true;
}

static void skip_space(reader* r) {
    while (r->at < r->end && (*r->at == ' ' || *r->at == '\t')) ++r->at;
}

static char peek(const reader* r) {
    return r->at < r->end ? *r->at : '\n';
}

// From `at` up to the line's end, to show; cut after a few characters.
static void rest_of_line(const reader* r, char out[SHOWN_CHARS_MAX + 1]) {
    size_t n = 0;
    for (const char* c = r->at; c < r->end && *c != '\n' && *c != '\r' && n < SHOWN_CHARS_MAX; ++c)
        out[n++] = (unsigned char)*c < 0x80 ? *c : '?';
    out[n] = '\0';
}

static bool end_line(reader* r) {
    skip_space(r);
    if (peek(r) != '#' && peek(r) != '\n' && peek(r) != '\r') {
        char rest[SHOWN_CHARS_MAX + 1];
        rest_of_line(r, rest);
        return refuse(r, r->line, "%s after the value; expected the end of the line or a # comment", rest);
    }
    while (r->at < r->end && *r->at != '\n') ++r->at;
    if (r->at < r->end) ++r->at;
    ++r->line;
    return true;
}

// ---- numbers

static bool read_number(reader* r, key k, float* out) {
    const char* stops = KEYS[k].n == AXES ? " \t\r\n#,]" : " \t\r\n#";
    char number[PAL_TOML_NUMBER_CHARS_MAX + 1];
    size_t n = 0;
    for (; r->at < r->end && strchr(stops, *r->at) == NULL; ++r->at) {
        if (n < PAL_TOML_NUMBER_CHARS_MAX) number[n] = (unsigned char)*r->at < 0x80 ? *r->at : '?';
        ++n;
    }
    number[n < PAL_TOML_NUMBER_CHARS_MAX ? n : PAL_TOML_NUMBER_CHARS_MAX] = '\0';
    const char* name = KEYS[k].name;
    const double low = (double)KEYS[k].low;
    const double high = (double)KEYS[k].high;
    if (n > PAL_TOML_NUMBER_CHARS_MAX)
        return refuse(r, r->line, "%s: a number of %zu characters; at most %d", name, n,
                      PAL_TOML_NUMBER_CHARS_MAX);
    switch (pal_toml_read_number(number, out)) {
        case PAL_TOML_NUMBER:
            break;
        case PAL_TOML_NO_NUMBER:
            return refuse(r, r->line,
                          "%s: %s is no number; expected a decimal one such as 0.06, -25 or 6e-2, %g to %g",
                          name, n > 0 ? number : "nothing", low, high);
        case PAL_TOML_NOT_FINITE:
            return refuse(r, r->line, "%s: %s is not finite; expected %g to %g", name, number, low, high);
        case PAL_TOML_TINY:
            return refuse(r, r->line, "%s: %s is too small for 32 bits; expected 0 or a number from %g to %g",
                          name, number, low, high);
    }
    if (!(*out >= KEYS[k].low && *out <= KEYS[k].high))
        return refuse(r, r->line, "%s: %s is out of range; expected %g to %g", name, number, low, high);
    if (k == MOTOR_MAX && *out != floorf(*out))
        return refuse(r, r->line, "%s: %s is no whole number; expected %g to %g", name, number, low, high);
    return true;
}

static bool read_list(reader* r, key k) {
    const char* name = KEYS[k].name;
    for (int i = 0; i < AXES; ++i) {
        const char wanted = i == 0 ? '[' : ',';
        if (peek(r) != wanted)
            return refuse(r, r->line,
                          "%s: no %c before number %d; expected [number, number, number] in one line", name,
                          wanted, i + 1);
        ++r->at;
        skip_space(r);
        if (!read_number(r, k, &r->values[k][i])) return false;
        skip_space(r);
    }
    if (peek(r) != ']')
        return refuse(r, r->line, "%s: no ] after three numbers; expected [number, number, number]", name);
    ++r->at;
    return true;
}

// ---- keys

static size_t least(size_t a, size_t b) {
    return a < b ? a : b;
}

// Levenshtein's distance, by rows.
static size_t distance(const char* a, const char* b) {
    size_t row[KEY_CHARS_MAX + 1];
    const size_t n = strlen(b);
    for (size_t j = 0; j <= n; ++j) row[j] = j;
    for (size_t i = 1; a[i - 1] != '\0'; ++i) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= n; ++j) {
            const size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0U : 1U);
            diagonal = row[j];
            row[j] = least(replaced, least(row[j], row[j - 1]) + 1);
        }
    }
    return row[n];
}

static bool unknown(const reader* r, const char* name) {
    key nearest = ARM;
    for (key k = ARM; k < N_KEYS; ++k) {
        if (distance(name, KEYS[k].name) < distance(name, KEYS[nearest].name)) nearest = k;
    }
    return refuse(r, r->line, "unknown key %s; the nearest known one is %s", name, KEYS[nearest].name);
}

static bool read_key(reader* r, key* out) {
    char name[KEY_CHARS_MAX + 1];
    size_t n = 0;
    char rest[SHOWN_CHARS_MAX + 1];
    rest_of_line(r, rest);
    if (peek(r) == '[') return refuse(r, r->line, "%s; expected keys without sections", rest);
    while (n < KEY_CHARS_MAX && is_key_char(peek(r))) name[n++] = *r->at++;
    name[n] = '\0';
    while (is_key_char(peek(r))) ++r->at;
    skip_space(r);
    if (n == 0 || peek(r) != '=') return refuse(r, r->line, "%s; expected key = value", rest);
    ++r->at;
    skip_space(r);
    for (key k = ARM; k < N_KEYS; ++k) {
        if (strcmp(name, KEYS[k].name) != 0) continue;
        if (r->line_of[k] != 0)
            return refuse(r, r->line, "%s again, first in line %u; expected it once", name, r->line_of[k]);
        r->line_of[k] = r->line;
        *out = k;
        return true;
    }
    return unknown(r, name);
}

static bool read_lines(reader* r) {
    while (r->at < r->end) {
        skip_space(r);
        if (peek(r) != '#' && peek(r) != '\n' && peek(r) != '\r') {
            key k = ARM;
            if (!read_key(r, &k)) return false;
            if (!(KEYS[k].n == AXES ? read_list(r, k) : read_number(r, k, r->values[k]))) return false;
        }
        if (!end_line(r)) return false;
    }
    for (key k = ARM; k < N_KEYS; ++k) {
        if (r->line_of[k] == 0)
            return refuse(r, r->line, "%s is missing; expected %s = %s, %g to %g", KEYS[k].name, KEYS[k].name,
                          KEYS[k].n == AXES ? "[number, number, number]" : "number", (double)KEYS[k].low,
                          (double)KEYS[k].high);
    }
    return true;
}

// ---- geometry

static void fill(const reader* r, pal_delta_file* out) {
    static const double PI = 3.14159265358979323846;
    const float(*v)[AXES] = r->values;
    out->delta = (pal_delta){.arm_m = v[ARM][0],
                             .forearm_m = v[FOREARM][0],
                             .offset_m = v[OFFSET][0],
                             .platform_u_m = v[PLATFORM_U][0],
                             .platform_v_m = v[PLATFORM_V][0],
                             .base_u_m = v[BASE_U][0],
                             .base_v_m = v[BASE_V][0],
                             .counts_per_rad = v[COUNTS_PER_RAD][0],
                             .theta_zero_rad = v[THETA_ZERO][0] * RAD_PER_DEG,
                             .theta_min_rad = v[THETA_MIN][0] * RAD_PER_DEG,
                             .theta_max_rad = v[THETA_MAX][0] * RAD_PER_DEG,
                             .units_per_n_m = v[UNITS_PER_N_M][0],
                             .motor_max = (int16_t)v[MOTOR_MAX][0]};
    for (int i = 0; i < AXES; ++i) {
        const double leg_rad = (double)v[LEGS][i] * (PI / 180.0);
        out->delta.cos_leg[i] = (float)cos(leg_rad);
        out->delta.sin_leg[i] = (float)sin(leg_rad);
        out->centre_m[i] = v[CENTRE][i];
    }
}

static bool check_geometry(const reader* r, const pal_delta_file* file) {
    const pal_delta* g = &file->delta;
    const float* centre_m = file->centre_m;
    float theta_rad[AXES], at_m[AXES];
    int16_t counts = 0;
    if (!(g->theta_min_rad < g->theta_max_rad))
        return refuse(r, r->line_of[THETA_MIN],
                      "theta_min_deg is not below theta_max_deg of line %u; expected less",
                      r->line_of[THETA_MAX]);
    if (!pal_delta_counts(g, g->theta_min_rad, &counts) || !pal_delta_counts(g, g->theta_max_rad, &counts))
        return refuse(
            r, r->line_of[COUNTS_PER_RAD],
            "counts_per_rad: the arms' travel from theta_zero_deg does not fit 16 bits; expected counts "
            "from -32768 to 32767");
    if (!pal_delta_inverse(g, centre_m, theta_rad))
        return refuse(
            r, r->line_of[CENTRE],
            "centre_m: the arms do not reach it (no inverse kinematics); expected the middle of the "
            "workspace, metres in the device frame");
    for (int i = 0; i < AXES; ++i) {
        if (!(theta_rad[i] >= g->theta_min_rad && theta_rad[i] <= g->theta_max_rad))
            return refuse(
                r, r->line_of[CENTRE],
                "centre_m: arm %d would stand at %.1f degrees; expected theta_min_deg to theta_max_deg",
                i + 1, (double)(theta_rad[i] / RAD_PER_DEG));
    }
    // Its first step inverts the Jacobian there, as the map from force to torque does.
    bool regular = pal_delta_forward(g, theta_rad, centre_m, SEARCH_STEPS, at_m);
    for (int i = 0; i < AXES && regular; ++i) regular = fabsf(at_m[i] - centre_m[i]) < SAME_PLACE_M;
    if (!regular)
        return refuse(
            r, r->line_of[CENTRE],
            "centre_m: the mechanism is singular there; expected three legs apart (leg_deg, line %u) and "
            "arms neither stretched nor folded",
            r->line_of[LEGS]);
    return true;
}

bool pal_delta_file_parse(const char* name, const char* text, size_t n_bytes, pal_delta_file* out,
                          char why[PAL_DELTA_WORDS_BYTES]) {
    reader r = {.name = name, .at = text, .end = text + n_bytes, .line = 1, .why = why};
    pal_delta_file file;
    why[0] = '\0';
    if (n_bytes > PAL_DELTA_FILE_BYTES_MAX)
        return refuse(&r, 1, "longer than %d bytes; expected a few lines of text", PAL_DELTA_FILE_BYTES_MAX);
    if (!check_text(&r) || !read_lines(&r)) return false;
    fill(&r, &file);
    if (!check_geometry(&r, &file)) return false;
    *out = file;
    return true;
}

// ---- the file

bool pal_delta_file_read(const char* path, pal_delta_file* out, char why[PAL_DELTA_WORDS_BYTES]) {
    char text[PAL_DELTA_FILE_BYTES_MAX + 1];
    why[0] = '\0';
    if (path == NULL) {
        *out = (pal_delta_file){.delta = PAL_DELTA_NF1,
                                .centre_m = {(float)PAL_WORKSPACE_CENTRE_X_M, (float)PAL_WORKSPACE_CENTRE_Y_M,
                                             (float)PAL_WORKSPACE_CENTRE_Z_M}};
        return true;
    }
    const reader r = {.name = path, .why = why};
    const char* reason = "";
    FILE* file = pal_regular_file_open(path, &reason);
    if (file == NULL) return refuse(&r, 0, "%s; expected a file such as nf1.toml", reason);
    const size_t n_bytes = fread(text, 1, sizeof text, file);
    const bool failed = ferror(file) != 0;
    const int error = errno;
    (void)fclose(file);
    if (failed) return refuse(&r, 0, "%s while reading it", strerror(error));
    return pal_delta_file_parse(path, text, n_bytes, out, why);
}
