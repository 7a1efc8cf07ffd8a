#include "common/crc32c.h"

// The CRC of a byte is that of its bits, XORed. So 64 numbers make the eight tables, at compile time:
// BYTE_k(i) is the CRC of byte i with k zero bytes after it. The numbers are the powers of x modulo the
// reflected polynomial 0x82F63B78, one step from the next, from BYTE_0's last to BYTE_7's first.
#define BIT(i, n, crc) (((i) >> (n)&1U) != 0U ? (crc) : 0U)
#define BITS(i, b0, b1, b2, b3, b4, b5, b6, b7)                                                     \
    BIT(i, 0, b0) ^ BIT(i, 1, b1) ^ BIT(i, 2, b2) ^ BIT(i, 3, b3) ^ BIT(i, 4, b4) ^ BIT(i, 5, b5) ^ \
        BIT(i, 6, b6) ^ BIT(i, 7, b7)
// clang-format off
#define BYTE_0(i) BITS(i, 0xF26B8303U, 0xE13B70F7U, 0xC79A971FU, 0x8AD958CFU, 0x105EC76FU, 0x20BD8EDEU, 0x417B1DBCU, 0x82F63B78U)
#define BYTE_1(i) BITS(i, 0x13A29877U, 0x274530EEU, 0x4E8A61DCU, 0x9D14C3B8U, 0x3FC5F181U, 0x7F8BE302U, 0xFF17C604U, 0xFBC3FAF9U)
#define BYTE_2(i) BITS(i, 0xA541927EU, 0x4F6F520DU, 0x9EDEA41AU, 0x38513EC5U, 0x70A27D8AU, 0xE144FB14U, 0xC76580D9U, 0x8B277743U)
#define BYTE_3(i) BITS(i, 0xDD45AAB8U, 0xBF672381U, 0x7B2231F3U, 0xF64463E6U, 0xE964B13DU, 0xD725148BU, 0xABA65FE7U, 0x52A0C93FU)
#define BYTE_4(i) BITS(i, 0x38116FACU, 0x7022DF58U, 0xE045BEB0U, 0xC5670B91U, 0x8F2261D3U, 0x1BA8B557U, 0x37516AAEU, 0x6EA2D55CU)
#define BYTE_5(i) BITS(i, 0xEF306B19U, 0xDB8CA0C3U, 0xB2F53777U, 0x6006181FU, 0xC00C303EU, 0x85F4168DU, 0x0E045BEBU, 0x1C08B7D6U)
#define BYTE_6(i) BITS(i, 0x68032CC8U, 0xD0065990U, 0xA5E0C5D1U, 0x4E2DFD53U, 0x9C5BFAA6U, 0x3D5B83BDU, 0x7AB7077AU, 0xF56E0EF4U)
#define BYTE_7(i) BITS(i, 0x493C7D27U, 0x9278FA4EU, 0x211D826DU, 0x423B04DAU, 0x847609B4U, 0x0D006599U, 0x1A00CB32U, 0x34019664U)
// clang-format on
#define FOUR(f, i) f((i)), f((i) + 1U), f((i) + 2U), f((i) + 3U)
#define SIXTEEN(f, i) FOUR(f, i), FOUR(f, (i) + 4U), FOUR(f, (i) + 8U), FOUR(f, (i) + 12U)
#define SIXTY_FOUR(f, i) SIXTEEN(f, i), SIXTEEN(f, (i) + 16U), SIXTEEN(f, (i) + 32U), SIXTEEN(f, (i) + 48U)
#define ALL(f) \
    { SIXTY_FOUR(f, 0U), SIXTY_FOUR(f, 64U), SIXTY_FOUR(f, 128U), SIXTY_FOUR(f, 192U) }

static const uint32_t CRC_OF_BYTE[8][256] = {ALL(BYTE_0), ALL(BYTE_1), ALL(BYTE_2), ALL(BYTE_3),
                                             ALL(BYTE_4), ALL(BYTE_5), ALL(BYTE_6), ALL(BYTE_7)};

static uint32_t little_endian(const unsigned char* at) {
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

// CRC of four bytes with `n_after` more after them.
static uint32_t crc_of_four(uint32_t word, int n_after) {
    return CRC_OF_BYTE[n_after + 3][word & 0xFFU] ^ CRC_OF_BYTE[n_after + 2][word >> 8 & 0xFFU] ^
           CRC_OF_BYTE[n_after + 1][word >> 16 & 0xFFU] ^ CRC_OF_BYTE[n_after][word >> 24];
}

uint32_t pal_crc32c_more(uint32_t crc_so_far, const void* bytes, size_t n_bytes) {
    const unsigned char* at = (const unsigned char*)bytes;
    uint32_t crc = ~crc_so_far;
    // Eight at a time ("slicing by 8", Kounavis and Berry 2005): the look-ups do not wait for each other.
    for (; n_bytes >= 8; n_bytes -= 8, at += 8) {
        crc = crc_of_four(crc ^ little_endian(at), 4) ^ crc_of_four(little_endian(at + 4), 0);
    }
    for (; n_bytes > 0; --n_bytes, ++at) crc = CRC_OF_BYTE[0][(crc ^ *at) & 0xFFU] ^ (crc >> 8);
    return ~crc;
}

uint32_t pal_crc32c(const void* bytes, size_t n_bytes) {
    return pal_crc32c_more(0, bytes, n_bytes);  // of nothing: 0
}
