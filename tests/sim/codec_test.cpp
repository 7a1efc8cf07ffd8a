#include "sim/falcon/codec.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <random>

#include "sim/falcon/falcon_sim.h"

namespace {

using Packet = std::array<uint8_t, 16>;

struct Request {
    std::array<int16_t, 3> words;
    uint8_t flags;
    Packet bytes;
};

/// docs/PROTOCOL.md 4.
const std::array<Request, 6> kRequests{{
    {{0, 0, 0}, 0, {'<', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', '>'}},
    {{1000, -1000, 4095},
     4,
     {0x3C, 0x49, 0x4F, 0x44, 0x41, 0x49, 0x42, 0x4D, 0x50, 0x50, 0x50, 0x50, 0x41, 0x45, 0x41, 0x3E}},
    {{-4095, 4095, -1},
     8,
     {0x3C, 0x42, 0x41, 0x41, 0x50, 0x50, 0x50, 0x50, 0x41, 0x50, 0x50, 0x50, 0x50, 0x49, 0x41, 0x3E}},
    {{0, 0, 0}, 9, {'<', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 0x4A, 'A', '>'}},
    {{32767, -32768, 0},
     0,
     {0x3C, 0x50, 0x50, 0x50, 0x48, 0x41, 0x41, 0x41, 0x49, 0x41, 0x41, 0x41, 0x41, 0x41, 0x41, 0x3E}},
    {{2752, 2780, 2888},
     4,
     {0x3C, 0x41, 0x4D, 0x4B, 0x41, 0x4D, 0x4E, 0x4B, 0x41, 0x49, 0x45, 0x4C, 0x41, 0x45, 0x41, 0x3E}},
}};

pal_falcon_sim fresh() {
    const pal_falcon_sim_config config = pal_falcon_sim_config_default();
    pal_falcon_sim sim;
    REQUIRE(pal_falcon_sim_init(&sim, &config));
    return sim;
}

}  // namespace

TEST_CASE("requests decode to the published vectors") {
    const auto& vector = kRequests[GENERATE(as<std::size_t>{}, 0, 1, 2, 3, 4, 5)];
    for (unsigned n = 0; n < 16; ++n) REQUIRE(pal_falcon_request_byte_ok(vector.bytes[n], n));
    const pal_falcon_request request = pal_falcon_request_decode(vector.bytes.data());
    for (std::size_t i = 0; i < 3; ++i) CHECK(request.motor_counts[i] == vector.words[i]);
    CHECK(request.flags == vector.flags);
}

TEST_CASE("replies encode to the published vectors") {
    const int16_t counts[3] = {-1447, 0, 1};
    const Packet homed{0x3C, 0x4A, 0x46, 0x4B, 0x50, 0x41, 0x41, 0x41,
                       0x41, 0x42, 0x41, 0x41, 0x41, 0xB1, 0x41, 0x3E};
    Packet packet{};
    pal_falcon_reply_encode(counts, 0x70, packet.data());
    CHECK(packet == homed);
    const int16_t zero[3] = {0, 0, 0};
    pal_falcon_reply_encode(zero, 0x7F, packet.data());
    CHECK(packet[13] == 0xC0);
    const int16_t ends[3] = {32767, -32768, 0};
    pal_falcon_reply_encode(ends, 0, packet.data());
    CHECK(packet == kRequests[4].bytes);
}

TEST_CASE("words beyond the motors' range saturate") {
    pal_falcon_sim sim = fresh();
    pal_falcon_sim_receive(&sim, kRequests[4].bytes.data(), 16);
    CHECK(sim.queued_counts[0][0] == 4095);
    CHECK(sim.queued_counts[0][1] == -4095);
}

TEST_CASE("a packet split at any byte is whole again") {
    const auto split = GENERATE(range(std::size_t{0}, std::size_t{17}));
    pal_falcon_sim sim = fresh();
    const auto& vector = kRequests[1];
    pal_falcon_sim_receive(&sim, vector.bytes.data(), split);
    CHECK(sim.has_reply == (split == 16));
    pal_falcon_sim_receive(&sim, vector.bytes.data() + split, 16 - split);
    CHECK(sim.has_reply);
    CHECK(sim.queued_counts[0][2] == 4095);
}

TEST_CASE("a packet after any broken start is found") {
    const std::string junk =
        GENERATE(as<std::string>{}, "", "<", "<<", "<AAAA", "<AAAAAAAAAAAAAA<", "AAAA>", ">><",
                 "<AAAAAAAAAAAAAAA>", std::string("\0\xFF<\x7F", 4), "<AAAAAAAAAAAAAA");
    pal_falcon_sim sim = fresh();
    pal_falcon_sim_receive(&sim, reinterpret_cast<const uint8_t*>(junk.data()), junk.size());
    CHECK_FALSE(sim.has_reply);
    pal_falcon_sim_receive(&sim, kRequests[1].bytes.data(), 16);
    CHECK(sim.has_reply);
    CHECK(sim.queued_counts[0][0] == 1000);
}

TEST_CASE("a byte damaged anywhere drops that packet and none after it") {
    const auto place = GENERATE(range(std::size_t{0}, std::size_t{16}));
    pal_falcon_sim sim = fresh();
    Packet damaged = kRequests[1].bytes;
    damaged[place] = 0x20;
    pal_falcon_sim_receive(&sim, damaged.data(), 16);
    CHECK_FALSE(sim.has_reply);
    CHECK(sim.queued_counts[0][0] == 0);
    pal_falcon_sim_receive(&sim, kRequests[1].bytes.data(), 16);
    CHECK(sim.has_reply);
}

TEST_CASE("random bytes never do harm") {
    std::mt19937_64 random(5);
    pal_falcon_sim sim = fresh();
    for (int round = 0; round < 2000; ++round) {
        std::array<uint8_t, 61> bytes{};
        for (auto& byte : bytes) {
            const auto dice = random();
            byte = static_cast<uint8_t>(
                dice % 4 == 0 ? dice >> 8
                              : (dice % 4 == 1 ? '<' + 2 * (dice >> 8 & 1) : 'A' + (dice >> 8) % 16));
        }
        pal_falcon_sim_receive(&sim, bytes.data(), random() % bytes.size());
        pal_falcon_sim_advance(&sim, nullptr, nullptr, 0);
        REQUIRE(sim.n_rx < 16);
        double theta[3];
        REQUIRE(pal_falcon_sim_theta(sim.position_m, theta));
    }
}

TEST_CASE("one request has one reply") {
    pal_falcon_sim sim = fresh();
    Packet reply{};
    CHECK_FALSE(pal_falcon_sim_reply(&sim, reply.data()));
    pal_falcon_sim_receive(&sim, kRequests[0].bytes.data(), 16);
    CHECK(pal_falcon_sim_reply(&sim, reply.data()));
    CHECK_FALSE(pal_falcon_sim_reply(&sim, reply.data()));
    CHECK(reply[0] == '<');
    CHECK(reply[15] == '>');
}
