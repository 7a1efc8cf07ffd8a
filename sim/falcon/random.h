/// SplitMix64: the one source of all that is random in the simulated device. The caller keeps the state.
#pragma once
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

/// The next number of the sequence that `*state` seeds.
static inline uint64_t pal_sim_random(uint64_t* state) {
    *state += 0x9E3779B97F4A7C15U;
    uint64_t z = *state;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31);
}

#ifdef __cplusplus
}
#endif
