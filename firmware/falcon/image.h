/// The firmware image: the boot stream of TI's C2000 loaders (SPRU095C), taken apart block by block before a
/// byte of it is sent, and named by its SHA-256. The images themselves are not ours to ship: the user gives
/// the file.
#pragma once
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

enum { PAL_IMAGE_BYTES_MAX = 65536, PAL_SHA256_BYTES = 32 };

typedef enum pal_image_problem {
    PAL_IMAGE_OK = 0,
    PAL_IMAGE_SHORT,     ///< ends within the header
    PAL_IMAGE_LONG,      ///< more than PAL_IMAGE_BYTES_MAX: cannot be for this device
    PAL_IMAGE_KEY,       ///< does not start with AA 08
    PAL_IMAGE_RESERVED,  ///< a reserved word of the header is not 0
    PAL_IMAGE_ADDRESS,   ///< an entry or block beyond the DSP's 22 address bits
    PAL_IMAGE_CUT,       ///< ends within a block or before the end mark
    PAL_IMAGE_EMPTY,     ///< no block at all
    PAL_IMAGE_TRAILING   ///< bytes after the end mark
} pal_image_problem;

typedef struct pal_image_info {
    uint32_t entry;       ///< word address of the first instruction
    uint32_t n_blocks;    ///< up to the problem, if there is one
    uint32_t n_words;     ///< in these blocks
    uint32_t problem_at;  ///< byte offset of what is wrong
} pal_image_info;

/// Reads the whole stream. `info` may be NULL.
pal_image_problem pal_image_check(const uint8_t* bytes, size_t n_bytes, pal_image_info* info);
/// One sentence; "" for OK. Never NULL.
const char* pal_image_words(pal_image_problem problem);

/// SHA-256 (FIPS 180-4). Here and not in the host so that every port, a microcontroller too, can say which
/// image it loads without another library.
void pal_sha256(const uint8_t* bytes, size_t n_bytes, uint8_t digest[PAL_SHA256_BYTES]);
/// Name of a published image with this digest; NULL when it is none of them, which is no error.
const char* pal_image_name(const uint8_t digest[PAL_SHA256_BYTES]);

#ifdef __cplusplus
}
#endif
