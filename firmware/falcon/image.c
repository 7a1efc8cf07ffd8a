#include "firmware/falcon/image.h"

#include <string.h>

enum {
    KEY_LOW = 0xAA,
    KEY_HIGH = 0x08,
    RESERVED_AT = 2,
    ENTRY_AT = 18,
    BLOCKS_AT = 22,
    ADDRESS_BYTES = 4,
    NAME_BYTES = 24,
    ADDRESS_END = 0x400000  // one past the last word address of a C28x
};

static uint32_t word_at(const uint8_t* bytes) {
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8U;
}

// A 32-bit address: high word first, each word little-endian.
static uint32_t address_at(const uint8_t* bytes) {
    return word_at(bytes) << 16U | word_at(bytes + 2);
}

static pal_image_problem at(pal_image_info* info, size_t offset, pal_image_problem problem) {
    info->problem_at = (uint32_t)offset;
    return problem;
}

static pal_image_problem check_header(const uint8_t* bytes, size_t n_bytes, pal_image_info* info) {
    if (n_bytes > PAL_IMAGE_BYTES_MAX) return at(info, PAL_IMAGE_BYTES_MAX, PAL_IMAGE_LONG);
    if (n_bytes >= 2 && (bytes[0] != KEY_LOW || bytes[1] != KEY_HIGH)) return at(info, 0, PAL_IMAGE_KEY);
    if (n_bytes < BLOCKS_AT) return at(info, n_bytes, PAL_IMAGE_SHORT);
    for (size_t i = RESERVED_AT; i < ENTRY_AT; ++i) {
        if (bytes[i] != 0) return at(info, i, PAL_IMAGE_RESERVED);
    }
    info->entry = address_at(bytes + ENTRY_AT);
    return info->entry < ADDRESS_END ? PAL_IMAGE_OK : at(info, ENTRY_AT, PAL_IMAGE_ADDRESS);
}

static pal_image_problem check_blocks(const uint8_t* bytes, size_t n_bytes, pal_image_info* info) {
    size_t offset = BLOCKS_AT;
    for (;;) {  // each round takes 2 bytes at least
        if (n_bytes - offset < 2) return at(info, offset, PAL_IMAGE_CUT);
        const uint32_t n_words = word_at(bytes + offset);
        if (n_words == 0) break;
        if (n_bytes - offset < 2U + ADDRESS_BYTES + 2U * n_words) return at(info, offset, PAL_IMAGE_CUT);
        const uint32_t address = address_at(bytes + offset + 2);
        if (address >= ADDRESS_END || n_words > ADDRESS_END - address) {
            return at(info, offset + 2, PAL_IMAGE_ADDRESS);
        }
        offset += 2U + ADDRESS_BYTES + 2U * n_words;
        info->n_blocks += 1U;
        info->n_words += n_words;
    }
    if (info->n_blocks == 0) return at(info, offset, PAL_IMAGE_EMPTY);
    return offset + 2 == n_bytes ? PAL_IMAGE_OK : at(info, offset + 2, PAL_IMAGE_TRAILING);
}

pal_image_problem pal_image_check(const uint8_t* bytes, size_t n_bytes, pal_image_info* info) {
    pal_image_info found = {0, 0, 0, 0};
    pal_image_problem problem = check_header(bytes, n_bytes, &found);
    if (problem == PAL_IMAGE_OK) problem = check_blocks(bytes, n_bytes, &found);
    if (info != NULL) *info = found;
    return problem;
}

const char* pal_image_words(pal_image_problem problem) {
    switch (problem) {
        case PAL_IMAGE_OK:
            return "";
        case PAL_IMAGE_SHORT:
            return "the firmware file ends within its header; get a complete copy";
        case PAL_IMAGE_LONG:
            return "the file is far too long for Falcon firmware; is it another file?";
        case PAL_IMAGE_KEY:
            return "this is no Falcon firmware: it does not start with AA 08";
        case PAL_IMAGE_RESERVED:
            return "this is no Falcon firmware: a reserved word of its header is not 0";
        case PAL_IMAGE_ADDRESS:
            return "the firmware file is damaged: an address lies outside the processor";
        case PAL_IMAGE_CUT:
            return "the firmware file is cut off; get a complete copy";
        case PAL_IMAGE_EMPTY:
            return "the firmware file has no block to load";
        case PAL_IMAGE_TRAILING:
            return "the firmware file goes on after its end mark; get a clean copy";
    }
    return "";
}

typedef struct known {
    uint8_t digest[PAL_SHA256_BYTES];
    char name[NAME_BYTES];  // an array: a pointer would need relocation, and the table is to stay constant
} known;

static const known KNOWN[] = {
    {{0x11, 0x19, 0xe3, 0x9c, 0x39, 0xfa, 0xb1, 0xf3, 0x76, 0x78, 0xea, 0x62, 0xdf, 0xc7, 0x15, 0xb2,
      0x3d, 0xd8, 0x6e, 0xe7, 0xf1, 0x3d, 0x78, 0xf8, 0x8f, 0x70, 0x7d, 0x9f, 0x09, 0xb8, 0x96, 0xa1},
     "nvent_firmware.bin"},
    {{0xb2, 0x70, 0x0d, 0x5c, 0xd5, 0xca, 0x21, 0x7e, 0x48, 0x56, 0x5f, 0xb4, 0xde, 0x5a, 0x50, 0x2a,
      0x63, 0x6c, 0x53, 0xf6, 0xe0, 0x1e, 0xbd, 0x0c, 0xad, 0x19, 0x3e, 0x9f, 0x84, 0x85, 0x6c, 0x6a},
     "test_firmware.bin"},
    {{0xae, 0x83, 0x87, 0x30, 0xaf, 0x34, 0xb5, 0x82, 0x2c, 0x9c, 0x39, 0x49, 0x85, 0x9b, 0x44, 0x66,
      0x14, 0xaf, 0x04, 0x10, 0x73, 0x0b, 0x83, 0x2c, 0xc1, 0x7a, 0x6a, 0xd6, 0x27, 0xea, 0x64, 0xa4},
     "novint_T0.bin"},
    {{0xe0, 0xae, 0x35, 0x98, 0x67, 0x0f, 0xa1, 0xc8, 0xd9, 0x27, 0x7b, 0xd6, 0x94, 0x3c, 0x99, 0xb3,
      0x15, 0x2b, 0x97, 0xc4, 0x00, 0xc4, 0x6c, 0x1c, 0x42, 0xc6, 0x0d, 0xe7, 0x7f, 0xf4, 0xe8, 0x16},
     "novint_T2.bin"},
};

const char* pal_image_name(const uint8_t digest[PAL_SHA256_BYTES]) {
    for (size_t k = 0; k < sizeof KNOWN / sizeof KNOWN[0]; ++k) {
        if (memcmp(KNOWN[k].digest, digest, PAL_SHA256_BYTES) == 0) return KNOWN[k].name;
    }
    return NULL;
}
