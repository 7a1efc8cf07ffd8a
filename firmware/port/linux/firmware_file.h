/// The user's firmware file for the Falcon: where it is looked for, read and checked. No image is part of
/// palpate.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "firmware/falcon/image.h"
#ifdef __cplusplus
extern "C" {
#endif

#define PAL_FIRMWARE_VARIABLE "PALPATE_FALCON_FIRMWARE"
#define PAL_FIRMWARE_FILE "nvent_firmware.bin"

enum { PAL_FIRMWARE_PATH_BYTES = 512, PAL_FIRMWARE_HEX_BYTES = 65, PAL_FIRMWARE_WORDS_BYTES = 1536 };

typedef struct pal_firmware_file {
    char path[PAL_FIRMWARE_PATH_BYTES];
    char sha256[PAL_FIRMWARE_HEX_BYTES];
    const char* name;  ///< of a published image; NULL: none of them
    size_t n_bytes;
    uint8_t bytes[PAL_IMAGE_BYTES_MAX];
} pal_firmware_file;

/// Where it would be read from: `chosen`, else $PALPATE_FALCON_FIRMWARE, else nvent_firmware.bin in
/// $XDG_DATA_HOME/palpate/ or ~/.local/share/palpate/. False: none of these is set, or the path is too long.
bool pal_firmware_path(const char* chosen, char path[PAL_FIRMWARE_PATH_BYTES]);
/// Reads it and checks the container. False: `why` says what is wrong, which file is needed and where it
/// goes.
bool pal_firmware_read(const char* chosen, pal_firmware_file* out, char why[PAL_FIRMWARE_WORDS_BYTES]);

#ifdef __cplusplus
}
#endif
