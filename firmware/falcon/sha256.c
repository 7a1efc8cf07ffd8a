#include <string.h>

#include "firmware/falcon/image.h"

enum { BLOCK_BYTES = 64, ROUNDS = 64, LENGTH_AT = 56, STATE_WORDS = 8 };

// First 32 bits of the fractional parts of the cube roots of the first 64 primes (FIPS 180-4, 4.2.2).
static const uint32_t K[ROUNDS] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

static uint32_t turned(uint32_t x, uint32_t n) {
    return x >> n | x << (32U - n);
}

static uint32_t big_endian(const uint8_t* bytes) {
    return (uint32_t)bytes[0] << 24U | (uint32_t)bytes[1] << 16U | (uint32_t)bytes[2] << 8U | bytes[3];
}

static void put_big_endian(uint32_t word, uint8_t* bytes) {
    for (uint32_t i = 0; i < 4; ++i) bytes[i] = (uint8_t)(word >> (24U - 8U * i));
}

// FIPS 180-4, 6.2.2.
static void mix(uint32_t state[STATE_WORDS], const uint8_t block[BLOCK_BYTES]) {
    uint32_t w[ROUNDS];
    for (int t = 0; t < 16; ++t) w[t] = big_endian(block + 4 * t);
    for (int t = 16; t < ROUNDS; ++t) {
        const uint32_t s0 = turned(w[t - 15], 7) ^ turned(w[t - 15], 18) ^ w[t - 15] >> 3U;
        const uint32_t s1 = turned(w[t - 2], 17) ^ turned(w[t - 2], 19) ^ w[t - 2] >> 10U;
        w[t] = w[t - 16] + s0 + w[t - 7] + s1;
    }
    uint32_t v[STATE_WORDS];  // a to h
    for (int i = 0; i < STATE_WORDS; ++i) v[i] = state[i];
    for (int t = 0; t < ROUNDS; ++t) {
        const uint32_t s1 = turned(v[4], 6) ^ turned(v[4], 11) ^ turned(v[4], 25);
        const uint32_t choice = (v[4] & v[5]) ^ (~v[4] & v[6]);
        const uint32_t t1 = v[7] + s1 + choice + K[t] + w[t];
        const uint32_t s0 = turned(v[0], 2) ^ turned(v[0], 13) ^ turned(v[0], 22);
        const uint32_t majority = (v[0] & v[1]) ^ (v[0] & v[2]) ^ (v[1] & v[2]);
        for (int i = STATE_WORDS - 1; i > 0; --i) v[i] = v[i - 1];
        v[4] += t1;
        v[0] = t1 + s0 + majority;
    }
    for (int i = 0; i < STATE_WORDS; ++i) state[i] += v[i];
}

void pal_sha256(const uint8_t* bytes, size_t n_bytes, uint8_t digest[PAL_SHA256_BYTES]) {
    // Fractional parts of the square roots of the first 8 primes (5.3.3).
    uint32_t state[STATE_WORDS] = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                   0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
    size_t done = 0;
    for (; n_bytes - done >= BLOCK_BYTES; done += BLOCK_BYTES) mix(state, bytes + done);
    uint8_t last[BLOCK_BYTES] = {0};
    const size_t n_left = n_bytes - done;
    if (n_left > 0) memcpy(last, bytes + done, n_left);
    last[n_left] = 0x80;
    if (n_left >= LENGTH_AT) {
        mix(state, last);
        memset(last, 0, sizeof last);
    }
    const uint64_t n_bits = (uint64_t)n_bytes * 8U;
    put_big_endian((uint32_t)(n_bits >> 32U), last + LENGTH_AT);
    put_big_endian((uint32_t)n_bits, last + LENGTH_AT + 4);
    mix(state, last);
    for (int i = 0; i < STATE_WORDS; ++i) put_big_endian(state[i], digest + 4 * i);
}
