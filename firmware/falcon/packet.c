#include "firmware/falcon/packet.h"

enum {
    OPEN = 0x3C,
    CLOSE = 0x3E,
    ZERO = 0x41,          // a digit d travels as 0x41 + d
    DIGITS_PER_WORD = 4,  // four bits each, least significant first
    FLAGS_AT = 13,
    UNKNOWN_AT = 14,
    CLOSE_AT = 15,
    REQUEST_FLAGS = 0x0F,
    FLAGS_MAX = 0x7F,
    BUTTONS_MASK = 0x0F,
    HOMED_SHIFT = 4
};

static uint8_t coded(uint32_t digit) {
    return (uint8_t)(ZERO + digit);
}

static void put_word(int16_t value, uint8_t* at) {
    const uint32_t bits = (uint16_t)value;
    for (uint32_t d = 0; d < DIGITS_PER_WORD; ++d) at[d] = coded(bits >> (4U * d) & 0xFU);
}

static bool get_word(const uint8_t* at, int16_t* value) {
    uint32_t bits = 0;
    for (uint32_t d = 0; d < DIGITS_PER_WORD; ++d) {
        const uint32_t digit = (uint32_t)at[d] - ZERO;  // wraps far beyond 15 for a byte below 'A'
        if (digit > 0xFU) return false;
        bits |= digit << (4U * d);
    }
    *value = (int16_t)(bits < 0x8000U ? (int32_t)bits : (int32_t)bits - 0x10000);
    return true;
}

static void encode(const int16_t words[3], uint32_t flags, uint8_t packet[PAL_WIRE_BYTES]) {
    packet[0] = OPEN;
    for (int i = 0; i < 3; ++i) put_word(words[i], packet + 1 + DIGITS_PER_WORD * i);
    packet[FLAGS_AT] = coded(flags);
    packet[UNKNOWN_AT] = coded(0);
    packet[CLOSE_AT] = CLOSE;
}

void pal_packet_encode(const pal_wire_request* request, uint8_t packet[PAL_WIRE_BYTES]) {
    encode(request->motor_counts, request->flags & (uint32_t)REQUEST_FLAGS, packet);
}

void pal_packet_encode_reply(const pal_wire_reply* reply, uint8_t packet[PAL_WIRE_BYTES]) {
    const uint32_t homed = (uint32_t)reply->homed << HOMED_SHIFT;
    encode(reply->encoder_counts, ((reply->buttons & (uint32_t)BUTTONS_MASK) | homed) & (uint32_t)FLAGS_MAX,
           packet);
}

bool pal_packet_decode(const uint8_t packet[PAL_WIRE_BYTES], pal_wire_reply* reply) {
    if (packet[0] != OPEN || packet[CLOSE_AT] != CLOSE) return false;
    int16_t counts[3];
    for (int i = 0; i < 3; ++i) {
        if (!get_word(packet + 1 + DIGITS_PER_WORD * i, &counts[i])) return false;
    }
    const uint32_t flags = (uint32_t)packet[FLAGS_AT] - ZERO;
    if (flags > FLAGS_MAX) return false;
    for (int i = 0; i < 3; ++i) reply->encoder_counts[i] = counts[i];
    reply->buttons = (uint8_t)(flags & BUTTONS_MASK);
    reply->homed = (uint8_t)(flags >> HOMED_SHIFT);
    return true;
}

bool pal_wire_feed(pal_wire_reader* reader, uint8_t byte) {
    if (reader->n_bytes == PAL_WIRE_BYTES) reader->n_bytes = 0;
    if (byte == OPEN) {
        reader->n_skipped_bytes += reader->n_bytes;
        reader->n_bytes = 0;
    } else if (reader->n_bytes == 0) {
        reader->n_skipped_bytes += 1U;
        return false;
    }
    reader->bytes[reader->n_bytes] = byte;
    reader->n_bytes = (uint8_t)(reader->n_bytes + 1);
    if (reader->n_bytes < PAL_WIRE_BYTES) return false;
    if (byte == CLOSE) return true;
    reader->n_skipped_bytes += PAL_WIRE_BYTES;
    reader->n_bytes = 0;
    return false;
}
