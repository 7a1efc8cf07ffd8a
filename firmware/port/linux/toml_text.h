/// What TOML 1.0 says of text, which is UTF-8, and of decimal numbers, for readers of a part of it.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

enum { PAL_TOML_NUMBER_CHARS_MAX = 63 };

/// Bytes of the character of UTF-8 that begins at `text`, of which `n_bytes` are there, 1 or more; 0: none
/// begins here. No surrogates, nothing longer than needed.
size_t pal_utf8_character_bytes(const char* text, size_t n_bytes);

typedef enum pal_toml_text { PAL_TOML_TEXT = 0, PAL_TOML_NOT_UTF8, PAL_TOML_CONTROL } pal_toml_text;

/// Is it UTF-8 without control characters but tab, LF and CR before LF? If not, `line` (from 1) and `byte`
/// say where.
pal_toml_text pal_toml_check_text(const char* text, size_t n_bytes, uint32_t* line, uint8_t* byte);

typedef enum pal_toml_number {
    PAL_TOML_NUMBER = 0,
    PAL_TOML_NO_NUMBER,   ///< or none of this part: hexadecimal, a text, a date, longer than the most
    PAL_TOML_NOT_FINITE,  ///< inf, nan, or beyond a float
    PAL_TOML_TINY         ///< not 0, but below a normal float
} pal_toml_number;

/// The float nearest to the decimal integer or float `word`; underscores as TOML has them. The locale does
/// not matter. `out` is untouched unless it is a number.
pal_toml_number pal_toml_read_number(const char* word, float* out);

#ifdef __cplusplus
}
#endif
