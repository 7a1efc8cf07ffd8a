#include "sim/falcon/codec.h"

enum { OPEN = '<', CLOSE = '>', ZERO = 'A', NIBBLES = 4, FLAGS_AT = 13, SPARE_AT = 14, CLOSE_AT = 15 };

bool pal_falcon_request_byte_ok(uint8_t byte, unsigned n) {
    if (n == 0) return byte == OPEN;
    if (n == CLOSE_AT) return byte == CLOSE;
    return byte >= ZERO && byte < ZERO + 16;
}

pal_falcon_request pal_falcon_request_decode(const uint8_t packet[16]) {
    pal_falcon_request request = {
        {0, 0, 0}, (uint8_t)(packet[FLAGS_AT] - ZERO), (uint8_t)(packet[SPARE_AT] - ZERO)};
    for (unsigned i = 0; i < 3; ++i) {
        const uint8_t* digits = packet + 1 + NIBBLES * i;
        int32_t word = 0;
        for (int n = NIBBLES - 1; n >= 0; --n) word = word * 16 + (digits[n] - ZERO);
        if (word >= 0x8000) word -= 0x10000;
        request.motor_counts[i] = (int16_t)word;
    }
    return request;
}

void pal_falcon_reply_encode(const int16_t encoder_counts[3], uint8_t flags, uint8_t packet[16]) {
    packet[0] = OPEN;
    for (unsigned i = 0; i < 3; ++i) {
        unsigned word = (uint16_t)encoder_counts[i];
        for (unsigned n = 0; n < NIBBLES; ++n) {
            packet[1 + NIBBLES * i + n] = (uint8_t)(ZERO + word % 16);
            word /= 16;
        }
    }
    packet[FLAGS_AT] = (uint8_t)(ZERO + (flags & 0x7F));
    packet[SPARE_AT] = ZERO;
    packet[CLOSE_AT] = CLOSE;
}
