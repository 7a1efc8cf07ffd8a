#include <array>
#include <catch2/catch.hpp>
#include <cstring>

#include "sim/falcon/falcon_sim.h"
#include "sim/hand/hand.h"

namespace {

/// FNV-1a, 64 bits.
void mix(uint64_t& hash, const void* bytes, std::size_t n_bytes) {
    for (std::size_t i = 0; i < n_bytes; ++i) {
        hash = (hash ^ static_cast<const unsigned char*>(bytes)[i]) * 0x100000001B3U;
    }
}

/// Three seconds in a firm hand on a bent path, motor words that change each tick.
uint64_t digest(double mass_kg) {
    const std::array<pal_hand_point, 4> path{{{0.0, {0.01, -0.02, 0.13}},
                                              {0.7, {-0.03, 0.011, 0.101}},
                                              {1.1, {0.027, 0.033, 0.15}},
                                              {2.0, {0.0, -0.035, 0.09}}}};
    pal_falcon_sim_config device = pal_falcon_sim_config_default();
    device.mass_kg = mass_kg;
    pal_hand_config grip{};
    grip.mass_kg = 0.15;
    grip.stiffness_n_per_m = 500;
    grip.damping_n_s_per_m = 8;
    grip.weight_n = 1.962;
    grip.home_in_m[2] = 0.07;
    grip.wait_ticks = 300;
    grip.path = path.data();
    grip.n_points = path.size();
    pal_falcon_sim sim;
    pal_hand hand;
    REQUIRE(pal_falcon_sim_init(&sim, &device));
    pal_hand_init(&hand, &grip);
    uint64_t hash = 0xCBF29CE484222325U;
    std::array<unsigned char, 16> packet{'<', 'A', 'A', 'A', 'A', 'A', 'A', 'A',
                                         'A', 'A', 'A', 'A', 'A', 'B', 'A', '>'};
    for (unsigned tick = 0; tick < 3000; ++tick) {
        for (unsigned i = 0; i < 3; ++i) {
            packet[1 + 4 * i] = static_cast<unsigned char>('A' + (tick * (i + 3) >> 1) % 16);
            packet[2 + 4 * i] = static_cast<unsigned char>('A' + (tick * (i + 5) >> 3) % 16);
        }
        pal_falcon_sim_receive(&sim, packet.data(), packet.size());
        pal_hand_advance(&hand, sim.homed == 7, sim.position_m);
        pal_falcon_sim_advance(&sim, pal_hand_push, &hand, grip.mass_kg);
        uint8_t reply[16];
        REQUIRE(pal_falcon_sim_reply(&sim, reply));
        mix(hash, reply, sizeof reply);
        mix(hash, sim.position_m, sizeof sim.position_m);
        mix(hash, sim.force_n, sizeof sim.force_n);
    }
    return hash;
}

}  // namespace

TEST_CASE("the device and the hand move by the same bits on every compiler") {
    // Taken once with gcc 12 -O3; the same with -O0 and with clang 14. Changes when the model changes.
    CHECK(digest(0.2) == 0x4D6928B99D50C5C6U);
}

TEST_CASE("one ulp of the effector's mass changes the bits") {
    CHECK(digest(0.2) != digest(0.20000000000000004));
}
