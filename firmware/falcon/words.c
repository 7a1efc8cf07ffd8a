// What a device says to a person.
#include "firmware/falcon/falcon.h"

enum { DIGITS_MAX = 10 };

const char* pal_falcon_words(const pal_falcon* f) {
    pal_falcon_status now;
    pal_falcon_status_read(f, &now);
    return now.stage == PAL_STAGE_FAILED ? pal_failure_words(now.failure) : pal_stage_words(now.stage);
}

// Text in memory of the caller; what does not fit is left out.
typedef struct text {
    char* out;
    size_t n_bytes, length;
} text;

static void put(text* t, const char* words) {
    for (; *words != '\0' && t->length + 1 < t->n_bytes; ++words) t->out[t->length++] = *words;
}

static void put_number(text* t, uint32_t number) {
    char digits[DIGITS_MAX + 1];
    size_t at = DIGITS_MAX;
    digits[at] = '\0';
    do {
        digits[--at] = (char)('0' + number % 10U);
        number /= 10U;
    } while (number > 0);
    put(t, digits + at);
}

static void put_of(text* t, const char* what, uint32_t number, uint32_t total) {
    put(t, what);
    put_number(t, number);
    put(t, " of ");
    put_number(t, total);
}

// Attempt and rate mean something: there is an image, and the stage belongs to its upload.
static bool in_upload(const pal_falcon_status* now) {
    return now->n_image_bytes > 0 && now->at_stage >= PAL_STAGE_ASK && now->at_stage <= PAL_STAGE_FIRST_REPLY;
}

size_t pal_falcon_describe(const pal_falcon* f, char* out, size_t n_bytes) {
    if (n_bytes == 0) return 0;
    pal_falcon_status now;
    pal_falcon_status_read(f, &now);
    text t = {out, n_bytes, 0};
    put(&t, pal_falcon_words(f));
    const bool failed = now.stage == PAL_STAGE_FAILED;
    if (failed || in_upload(&now)) {
        put(&t, " (");
        put(&t, failed ? pal_failure_name(now.failure) : pal_stage_name(now.stage));
        const bool echo = now.failure == PAL_FAIL_ECHO_WRONG || now.failure == PAL_FAIL_ECHO_TIMEOUT;
        if (failed && echo) put_of(&t, " at byte ", now.failed_byte, now.n_image_bytes);
        if (now.stage == PAL_STAGE_UPLOAD) put_of(&t, ", byte ", now.n_echoed_bytes, now.n_image_bytes);
        if (in_upload(&now)) {
            put_of(&t, ", attempt ", now.attempt, now.n_attempts);
            put(&t, " at ");
            put_number(&t, now.baud);
            put(&t, " baud");
        }
        put(&t, ")");
    }
    out[t.length] = '\0';
    return t.length;
}
