#include "firmware/port/linux/firmware_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "firmware/port/linux/regular_file.h"

static const char* environment(const char* name) {
    const char* value = getenv(name);
    return value != NULL && value[0] != '\0' ? value : NULL;
}

bool pal_firmware_path(const char* chosen, char path[PAL_FIRMWARE_PATH_BYTES]) {
    const char* data = environment("XDG_DATA_HOME");
    const char* home = environment("HOME");
    const char* named = chosen != NULL ? chosen : environment(PAL_FIRMWARE_VARIABLE);
    int n = -1;
    if (named != NULL) {
        n = snprintf(path, PAL_FIRMWARE_PATH_BYTES, "%s", named);
    } else if (data != NULL) {
        n = snprintf(path, PAL_FIRMWARE_PATH_BYTES, "%s/palpate/%s", data, PAL_FIRMWARE_FILE);
    } else if (home != NULL) {
        n = snprintf(path, PAL_FIRMWARE_PATH_BYTES, "%s/.local/share/palpate/%s", home, PAL_FIRMWARE_FILE);
    }
    return n >= 0 && n < PAL_FIRMWARE_PATH_BYTES;
}

static bool missing(const char* path, const char* what, char why[PAL_FIRMWARE_WORDS_BYTES]) {
    (void)snprintf(
        why, PAL_FIRMWARE_WORDS_BYTES,
        "%s: %s. The Falcon forgets its firmware without power, so each session loads it from a file, "
        "which palpate may not bring along: Novint's licence. Wanted is %s (8492 bytes), as in the "
        "folder firmware of libnifalcon's sources. Put it into $XDG_DATA_HOME/palpate or "
        "~/.local/share/palpate, or name it by --firmware FILE or %s=FILE.",
        path, what, PAL_FIRMWARE_FILE, PAL_FIRMWARE_VARIABLE);
    return false;
}

static void name_it(pal_firmware_file* file) {
    static const char DIGITS[] = "0123456789abcdef";
    uint8_t digest[PAL_SHA256_BYTES];
    pal_sha256(file->bytes, file->n_bytes, digest);
    for (size_t i = 0; i < PAL_SHA256_BYTES; ++i) {
        file->sha256[2 * i] = DIGITS[digest[i] >> 4U];
        file->sha256[2 * i + 1] = DIGITS[digest[i] & 15U];
    }
    file->sha256[PAL_FIRMWARE_HEX_BYTES - 1] = '\0';
    file->name = pal_image_name(digest);
}

bool pal_firmware_read(const char* chosen, pal_firmware_file* out, char why[PAL_FIRMWARE_WORDS_BYTES]) {
    memset(out, 0, sizeof *out);
    if (!pal_firmware_path(chosen, out->path)) {
        return missing("firmware file", "not named, and there is no home folder to look in", why);
    }
    const char* reason = "";
    FILE* file = pal_regular_file_open(out->path, &reason);
    if (file == NULL) return missing(out->path, reason, why);
    out->n_bytes = fread(out->bytes, 1, sizeof out->bytes, file);
    const bool longer = out->n_bytes == sizeof out->bytes && fgetc(file) != EOF;
    const bool failed = ferror(file) != 0;
    const int error = errno;
    (void)fclose(file);
    if (failed) return missing(out->path, strerror(error), why);
    pal_image_info info = {.problem_at = PAL_IMAGE_BYTES_MAX};
    const pal_image_problem problem =
        longer ? PAL_IMAGE_LONG : pal_image_check(out->bytes, out->n_bytes, &info);
    if (problem != PAL_IMAGE_OK) {
        (void)snprintf(why, PAL_FIRMWARE_WORDS_BYTES, "%s: %s (byte %u). Wanted is %s.", out->path,
                       pal_image_words(problem), info.problem_at, PAL_FIRMWARE_FILE);
        return false;
    }
    name_it(out);
    return true;
}
