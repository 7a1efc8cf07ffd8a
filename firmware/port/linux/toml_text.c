#include "firmware/port/linux/toml_text.h"

#include <errno.h>
#include <locale.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

size_t pal_utf8_character_bytes(const char* text, size_t n) {
    static const uint32_t SMALLEST[] = {0, 0, 0x80, 0x800, 0x10000};
    const unsigned char* s = (const unsigned char*)text;
    const size_t length = s[0] < 0x80        ? 1
                          : s[0] >> 5U == 6  ? 2
                          : s[0] >> 4U == 14 ? 3
                          : s[0] >> 3U == 30 ? 4
                                             : 0;
    if (length <= 1 || length > n) return length <= n ? length : 0;
    uint32_t code = s[0] & (0x7FU >> length);
    for (size_t i = 1; i < length; ++i) {
        if (s[i] >> 6U != 2) return 0;
        code = code << 6U | (s[i] & 0x3FU);
    }
    return code < SMALLEST[length] || code > 0x10FFFF || code >> 11U == 27 ? 0 : length;
}

pal_toml_text pal_toml_check_text(const char* text, size_t n_bytes, uint32_t* line, uint8_t* byte) {
    const unsigned char* s = (const unsigned char*)text;
    *line = 1;
    for (size_t i = 0; i < n_bytes;) {
        const size_t n = pal_utf8_character_bytes(text + i, n_bytes - i);
        *byte = s[i];
        if (n == 0) return PAL_TOML_NOT_UTF8;
        const bool line_end = s[i] == '\n' || (s[i] == '\r' && i + 1 < n_bytes && s[i + 1] == '\n');
        if (!line_end && s[i] != '\t' && (s[i] < 0x20 || s[i] == 0x7F)) return PAL_TOML_CONTROL;
        if (s[i] == '\n') ++*line;
        i += n;
    }
    return PAL_TOML_TEXT;
}

// Length of the digits at `s`, with single _ between them; 0: none.
static size_t digits(const char* s) {
    size_t n = 0;
    while (is_digit(s[n]) || (n > 0 && s[n] == '_' && is_digit(s[n - 1]) && is_digit(s[n + 1]))) ++n;
    return n;
}

// A decimal integer or float of TOML.
static bool is_number(const char* s) {
    if (*s == '+' || *s == '-') ++s;
    size_t n = digits(s);
    if (n == 0 || (n > 1 && *s == '0')) return false;
    s += n;
    if (*s == '.') {
        n = digits(++s);
        if (n == 0) return false;
        s += n;
    }
    if (*s == 'e' || *s == 'E') {
        ++s;
        if (*s == '+' || *s == '-') ++s;
        n = digits(s);
        if (n == 0) return false;
        s += n;
    }
    return *s == '\0';
}

// The nearest float, in the C locale whichever is set. False: too small for one and not 0.
static bool convert(const char* number, float* out) {
    char plain[PAL_TOML_NUMBER_CHARS_MAX + 1];
    size_t n = 0;
    for (; *number != '\0'; ++number) {
        if (*number != '_') plain[n++] = *number;
    }
    plain[n] = '\0';
    const locale_t c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (c_locale == (locale_t)0) return false;
    errno = 0;
    *out = strtof_l(plain, NULL, c_locale);
    const bool small = errno == ERANGE && isfinite(*out);
    freelocale(c_locale);
    return !small;
}

static bool is_unfinite(const char* s) {
    if (*s == '+' || *s == '-') ++s;
    return strcmp(s, "inf") == 0 || strcmp(s, "nan") == 0;
}

pal_toml_number pal_toml_read_number(const char* word, float* out) {
    float value = 0.0F;
    if (is_unfinite(word)) return PAL_TOML_NOT_FINITE;
    if (strlen(word) > PAL_TOML_NUMBER_CHARS_MAX || !is_number(word)) return PAL_TOML_NO_NUMBER;
    if (!convert(word, &value)) return PAL_TOML_TINY;
    if (!isfinite(value)) return PAL_TOML_NOT_FINITE;
    *out = value;
    return PAL_TOML_NUMBER;
}
