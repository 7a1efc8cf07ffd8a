#include "sim/falcon/faults.h"

#include <string.h>

enum {
    US_PER_S = 1000000,
    SECONDS_MAX = 1000000,
    PER_MILLION = 1000000,
    FRACTION_DIGITS = 6,
    SPLIT_MAX = 61,
    LENGTH_MAX = 64,
    AXES = 3,
    STAGES = 7,
    COUNTS_MAX = 32767,
    NUMBER_MAX = 1000000000,
    DIGITS_MAX = 15,
    SHOWN_MAX = 32  // of a word, in a message
};

static const uint64_t VALUE_MAX = 1000000000000;  // of digits before the point is put in place

// Arrays of characters, not of pointers: nothing here is written by a loader.
static const char NAMES[PAL_USB_FAULT_KINDS][10] = {"drop",  "delay",  "split",     "duplicate", "corrupt",
                                                    "stall", "unplug", "power-out", "boot-fail", "freeze",
                                                    "jump",  "babble", "slow-host"};

/// What may stand behind a kind.
typedef enum field {
    F_AT = 1 << 0,
    F_FOR = 1 << 1,
    F_N = 1 << 2,
    F_DIR = 1 << 3,
    F_P = 1 << 4,
    F_BYTE = 1 << 5,
    F_LENGTH = 1 << 6,
    F_AXIS = 1 << 7,
    F_COUNTS = 1 << 8,
    F_STAGE = 1 << 9,
    F_EP = 1 << 10,
    F_BY = 1 << 11,
    F_GAP = 1 << 12,
    F_EVERY = 1 << 13
} field;

static const uint32_t FIELDS[PAL_USB_FAULT_KINDS] = {
    F_AT | F_FOR | F_N | F_DIR | F_P,
    F_AT | F_FOR | F_N | F_DIR | F_P | F_BY,
    F_AT | F_FOR | F_N | F_P | F_BYTE | F_GAP,
    F_AT | F_FOR | F_N | F_DIR | F_P,
    F_AT | F_FOR | F_N | F_DIR | F_P,
    F_AT | F_FOR | F_EP,
    F_AT | F_FOR,
    F_AT | F_FOR,
    F_AT | F_FOR | F_N | F_STAGE | F_BYTE,
    F_AT | F_FOR | F_AXIS,
    F_AT | F_AXIS | F_COUNTS,
    F_AT | F_FOR | F_N | F_LENGTH | F_EVERY,
    F_AT | F_FOR | F_N | F_EVERY,
};

pal_usb_fault pal_usb_fault_of(pal_usb_fault_kind kind) {
    pal_usb_fault fault;
    memset(&fault, 0, sizeof fault);
    fault.kind = kind;
    fault.dir = PAL_USB_FAULT_IN;
    fault.endpoints = PAL_USB_FAULT_EP_IN;
    fault.stage = 1;
    fault.per_million = PER_MILLION;
    fault.byte = kind == PAL_USB_FAULT_SPLIT ? 14 : 0;
    fault.length = 16;
    fault.counts = 100;
    fault.by_us = 1000;
    fault.every_us = kind == PAL_USB_FAULT_SLOW_HOST ? 0 : 1000;
    return fault;
}

const char* pal_usb_fault_name(pal_usb_fault_kind kind) {
    return (unsigned)kind < PAL_USB_FAULT_KINDS ? NAMES[kind] : "unknown";
}

const char* pal_usb_fault_problem(const pal_usb_fault* f) {
    const uint64_t longest_us = (uint64_t)SECONDS_MAX * US_PER_S;
    if ((unsigned)f->kind >= PAL_USB_FAULT_KINDS) return "the kind is unknown";
    if (f->at_us > longest_us || f->for_us > longest_us) return "at_s and for_s are at most 1000000";
    if ((f->kind == PAL_USB_FAULT_UNPLUG || f->kind == PAL_USB_FAULT_POWER_OUT ||
         f->kind == PAL_USB_FAULT_FREEZE || f->kind == PAL_USB_FAULT_SLOW_HOST) &&
        f->for_us == 0) {
        return "how long is missing: write for_s above 0, such as for_s=0.1";
    }
    if (f->dir < PAL_USB_FAULT_IN || f->dir > PAL_USB_FAULT_BOTH) return "dir is in, out or both";
    if (f->endpoints < 1 || f->endpoints > 7) return "ep is in, out or control";
    if (f->axis > AXES) return "axis is 1, 2 or 3, or 0 for all";
    if (f->stage < 1 || f->stage > STAGES) return "stage is 1 to 7";
    if (f->per_million > PER_MILLION) return "p is 0 to 1";
    if (f->kind == PAL_USB_FAULT_SPLIT && (f->byte < 1 || f->byte > SPLIT_MAX)) return "byte is 1 to 61";
    if (f->length < 1 || f->length > LENGTH_MAX) return "length is 1 to 64";
    if (f->counts < -COUNTS_MAX || f->counts > COUNTS_MAX) return "counts is -32767 to 32767";
    if (f->by_us > longest_us || f->gap_us > longest_us) return "by_s and gap_s are at most 1000000";
    if (f->kind == PAL_USB_FAULT_SLOW_HOST) {
        if (f->n > 0 && f->every_us == 0) return "n needs every_s, such as every_s=1";
        if (f->every_us > 0 && f->every_us <= f->for_us) return "every_s is longer than for_s";
    } else if (f->every_us < 1) {
        return "every_s is 0.000001 to 1000000";
    }
    if (f->every_us > longest_us) return "every_s is 0.000001 to 1000000";
    return NULL;
}

/// Characters that are looked at; never 0-terminated.
typedef struct span {
    const char* at;
    size_t n;
} span;

static size_t length_of(const char* text, size_t most) {
    size_t n = 0;
    while (n < most && text[n] != '\0') ++n;
    return n;
}

static bool is_word(span s, const char* word) {
    if (s.n != length_of(word, s.n + 1)) return false;
    for (size_t i = 0; i < s.n; ++i) {
        if (s.at[i] != word[i]) return false;
    }
    return true;
}

static bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

/// Cuts the next word off `rest`; empty when there is none.
static span next_word(span* rest) {
    while (rest->n > 0 && is_blank(*rest->at)) {
        ++rest->at;
        --rest->n;
    }
    span word = {rest->at, 0};
    while (word.n < rest->n && !is_blank(rest->at[word.n])) ++word.n;
    rest->at += word.n;
    rest->n -= word.n;
    return word;
}

/// Digits, at most `n_fraction` of them behind a point, as a whole number of 10^-n_fraction.
static bool read_decimal(span s, unsigned n_fraction, uint64_t* value) {
    uint64_t sum = 0;
    unsigned n_digits = 0;
    unsigned n_behind = 0;
    bool point = false;
    for (size_t i = 0; i < s.n; ++i) {
        if (s.at[i] == '.' && !point) {
            point = true;
            continue;
        }
        if (s.at[i] < '0' || s.at[i] > '9' || ++n_digits > DIGITS_MAX) return false;
        if (point && ++n_behind > n_fraction) return false;
        sum = sum * 10 + (uint64_t)(s.at[i] - '0');
    }
    if (sum > VALUE_MAX) return false;  // times 10^n_fraction it must fit
    for (; n_behind < n_fraction; ++n_behind) sum *= 10;
    *value = sum;
    return n_digits > 0 && !(point && n_fraction == 0);
}

static const char* read_us(span value, uint64_t* us) {
    if (read_decimal(value, FRACTION_DIGITS, us) && *us <= (uint64_t)SECONDS_MAX * US_PER_S) return NULL;
    return "write seconds, 0 to 1000000, not finer than a microsecond, such as 0.1";
}

/// `problem` comes back when `value` is no whole number up to `most`.
static const char* read_whole(span value, uint32_t most, const char* problem, uint32_t* number) {
    uint64_t wide;
    if (!read_decimal(value, 0, &wide) || wide > most) return problem;
    *number = (uint32_t)wide;
    return NULL;
}

static const char* read_byte(span value, uint8_t most, const char* problem, uint8_t* number) {
    uint32_t wide = 0;
    const char* found = read_whole(value, most, problem, &wide);
    if (!found) *number = (uint8_t)wide;
    return found;
}

static const char* read_p(span value, uint32_t* per_million) {
    uint64_t wide;
    if (!read_decimal(value, FRACTION_DIGITS, &wide) || wide > PER_MILLION)
        return "write 0 to 1, such as 0.01";
    *per_million = (uint32_t)wide;
    return NULL;
}

/// How often; 0, which means "no limit", is said by leaving it out.
static const char* read_n(span value, uint32_t* n) {
    static const char right[] = "write a whole number, 1 to 1000000000";
    const char* problem = read_whole(value, NUMBER_MAX, right, n);
    return !problem && *n == 0 ? right : problem;
}

static const char* read_counts(span value, int32_t* counts) {
    const bool negative = value.n > 0 && *value.at == '-';
    if (negative) value = (span){value.at + 1, value.n - 1};
    uint32_t wide = 0;
    const char* problem = read_whole(value, COUNTS_MAX, "write -32767 to 32767", &wide);
    if (!problem) *counts = negative ? -(int32_t)wide : (int32_t)wide;
    return problem;
}

static const char* read_dir(span value, uint8_t* dir) {
    if (is_word(value, "in")) {
        *dir = PAL_USB_FAULT_IN;
    } else if (is_word(value, "out")) {
        *dir = PAL_USB_FAULT_OUT;
    } else if (is_word(value, "both")) {
        *dir = PAL_USB_FAULT_BOTH;
    } else {
        return "write in, out or both";
    }
    return NULL;
}

static const char* read_ep(span value, uint8_t* endpoints) {
    if (is_word(value, "in")) {
        *endpoints = PAL_USB_FAULT_EP_IN;
    } else if (is_word(value, "out")) {
        *endpoints = PAL_USB_FAULT_EP_OUT;
    } else if (is_word(value, "control")) {
        *endpoints = PAL_USB_FAULT_EP_CONTROL;
    } else {
        return "write in, out or control";
    }
    return NULL;
}

static uint32_t field_of(span key) {
    static const char KEYS[][8] = {"at_s", "for_s",  "n",     "dir", "p",    "byte",  "length",
                                   "axis", "counts", "stage", "ep",  "by_s", "gap_s", "every_s"};
    for (unsigned i = 0; i < sizeof KEYS / sizeof *KEYS; ++i) {
        if (is_word(key, KEYS[i])) return 1U << i;
    }
    return 0;
}

static const char* read_value(uint32_t which, span value, pal_usb_fault* f) {
    switch (which) {
        case F_AT:
            return read_us(value, &f->at_us);
        case F_FOR:
            return read_us(value, &f->for_us);
        case F_N:
            return read_n(value, &f->n);
        case F_DIR:
            return read_dir(value, &f->dir);
        case F_P:
            return read_p(value, &f->per_million);
        case F_BYTE:
            return read_whole(value, NUMBER_MAX, "write a whole number, 0 to 1000000000", &f->byte);
        case F_LENGTH:
            return read_whole(value, LENGTH_MAX, "write a whole number, 1 to 64", &f->length);
        case F_AXIS:
            return read_byte(value, AXES, "write 1, 2 or 3, or 0 for all", &f->axis);
        case F_COUNTS:
            return read_counts(value, &f->counts);
        case F_STAGE:
            return read_byte(value, STAGES, "write 1 to 7", &f->stage);
        case F_EP:
            return read_ep(value, &f->endpoints);
        case F_BY:
            return read_us(value, &f->by_us);
        case F_GAP:
            return read_us(value, &f->gap_us);
        default:
            return read_us(value, &f->every_us);
    }
}

/// Appends to a message; what has no room is left out.
static void say(pal_usb_fault_error* error, span text) {
    const size_t room = sizeof error->message - 1;
    const size_t n_used = length_of(error->message, room);
    const size_t n = text.n < room - n_used ? text.n : room - n_used;
    memcpy(error->message + n_used, text.at, n);
    error->message[n_used + n] = '\0';
}

static void say_text(pal_usb_fault_error* error, const char* text) {
    say(error, (span){text, length_of(text, sizeof error->message)});
}

static void say_number(pal_usb_fault_error* error, uint32_t number) {
    char digits[10];
    size_t at = sizeof digits;
    do {
        digits[--at] = (char)('0' + number % 10);
        number /= 10;
    } while (number > 0);
    say(error, (span){digits + at, sizeof digits - at});
}

static int complain(pal_usb_fault_error* error, uint32_t line, span word, const char* what) {
    error->line = line;
    error->message[0] = '\0';
    say_text(error, "line ");
    say_number(error, line);
    say_text(error, ": ");
    say(error, (span){word.at, word.n < SHOWN_MAX ? word.n : SHOWN_MAX});
    say_text(error, ": ");
    say_text(error, what);
    return -1;
}

static int read_pair(span pair, uint32_t line, pal_usb_fault* f, uint32_t* seen, pal_usb_fault_error* error) {
    span key = pair;
    for (key.n = 0; key.n < pair.n && pair.at[key.n] != '=';) ++key.n;
    if (key.n == pair.n) return complain(error, line, pair, "write name=value, such as at_s=2");
    const span value = {pair.at + key.n + 1, pair.n - key.n - 1};
    const uint32_t which = field_of(key);
    if (!which) {
        return complain(
            error, line, key,
            "no such name; there are at_s for_s n dir p byte length axis counts stage ep by_s gap_s every_s");
    }
    if (!(which & FIELDS[f->kind]))
        return complain(error, line, key, "means nothing for this kind; leave it out");
    if (which & *seen) return complain(error, line, key, "comes twice; leave one out");
    *seen |= which;
    const char* problem = read_value(which, value, f);
    return problem ? complain(error, line, pair, problem) : 0;
}

/// 1: a fault; 0: an empty line; -1 with *error.
static int read_line(span rest, uint32_t line, pal_usb_fault* fault, pal_usb_fault_error* error) {
    for (size_t i = 0; i < rest.n; ++i) {
        if (rest.at[i] == '#') rest.n = i;
    }
    const span kind = next_word(&rest);
    if (kind.n == 0) return 0;
    int which = 0;
    while (which < PAL_USB_FAULT_KINDS && !is_word(kind, NAMES[which])) ++which;
    if (which == PAL_USB_FAULT_KINDS) {
        return complain(error, line, kind,
                        "no such fault; there are drop delay split duplicate corrupt stall unplug power-out "
                        "boot-fail freeze jump babble slow-host");
    }
    *fault = pal_usb_fault_of((pal_usb_fault_kind)which);
    uint32_t seen = 0;
    for (span pair = next_word(&rest); pair.n > 0; pair = next_word(&rest)) {
        if (read_pair(pair, line, fault, &seen, error) < 0) return -1;
    }
    const char* problem = pal_usb_fault_problem(fault);
    return problem ? complain(error, line, kind, problem) : 1;
}

int pal_usb_faults_parse(const char* text, size_t n_bytes, pal_usb_fault* faults, size_t n_max,
                         pal_usb_fault_error* error) {
    size_t n = 0;
    size_t at = 0;
    for (uint32_t line = 1; at < n_bytes; ++line) {
        span rest = {text + at, 0};
        while (at + rest.n < n_bytes && rest.at[rest.n] != '\n') ++rest.n;
        at += rest.n + 1;
        pal_usb_fault fault;
        const int got = read_line(rest, line, &fault, error);
        if (got < 0) return -1;
        if (got == 0) continue;
        if (n == n_max) return complain(error, line, rest, "too many faults; leave some out");
        faults[n++] = fault;
    }
    return (int)n;
}
