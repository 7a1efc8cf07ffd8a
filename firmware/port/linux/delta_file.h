/// Geometry and gains of a delta as a text file, so that another device needs no other program. The text is a
/// part of TOML 1.0: comments and `key = number` or `key = [number, number, number]`, each key once, in any
/// order. firmware/falcon/nf1.toml is the built-in one.
#pragma once
#include <stdbool.h>
#include <stddef.h>

#include "firmware/core/delta.h"
#ifdef __cplusplus
extern "C" {
#endif

enum { PAL_DELTA_FILE_BYTES_MAX = 65536, PAL_DELTA_WORDS_BYTES = 1024 };

typedef struct pal_delta_file {
    pal_delta delta;
    float centre_m[3];  ///< middle of the workspace in the device frame; the search for positions starts here
} pal_delta_file;

/// Reads `path`; NULL gives the built-in Falcon NF1. False: `why` has one line with file, line, what is wrong
/// and what would be right; `out` is untouched. What is accepted is usable: at centre_m the arms are within
/// their travel, the map from force to torque is regular, and all of the travel fits the encoder's 16 bits.
bool pal_delta_file_read(const char* path, pal_delta_file* out, char why[PAL_DELTA_WORDS_BYTES]);
/// The same for a text of `n_bytes`, with `name` for the words. The locale does not matter.
bool pal_delta_file_parse(const char* name, const char* text, size_t n_bytes, pal_delta_file* out,
                          char why[PAL_DELTA_WORDS_BYTES]);

#ifdef __cplusplus
}
#endif
