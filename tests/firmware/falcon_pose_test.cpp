#include "firmware/falcon/pose.h"

#include <catch2/catch.hpp>
#include <complex>

#include "firmware/falcon/packet.h"
#include "tests/firmware/falcon_truth.hpp"

namespace {

using truth::Three;
using Counts = std::array<std::int16_t, 3>;

pal_pose_config config() {
    return {{0.0F, 0.0F, 0.11F}, 300, 50.0F};
}

Counts read_at(const Three& p) {
    const auto exact = truth::counts(p);
    REQUIRE(exact);
    Counts counts{};
    for (std::size_t i = 0; i < 3; ++i) counts[i] = static_cast<std::int16_t>(std::lround((*exact)[i]));
    return counts;
}

}  // namespace

TEST_CASE("tracking at 1 m/s, the position is that of the encoders to 0.01 count") {
    pal_pose pose{};
    const pal_pose_config c = config();
    double worst = 0.0;
    for (int n = 0; n < 5000; ++n) {
        const double angle = n * 1e-3 * 1.0 / 0.03;  // a circle of 30 mm, tilted
        const Three p{0.03 * std::cos(angle), 0.03 * std::sin(angle), 0.12 + 0.01 * std::sin(angle)};
        const Counts counts = read_at(p);
        REQUIRE(pal_pose_step(&c, &PAL_DELTA_NF1, &pose, counts.data(), 1000) == 0);
        const auto back =
            truth::counts({static_cast<double>(pose.position_m[0]), static_cast<double>(pose.position_m[1]),
                           static_cast<double>(pose.position_m[2])});
        REQUIRE(back);
        for (std::size_t i = 0; i < 3; ++i) worst = std::max(worst, std::abs((*back)[i] - counts[i]));
    }
    CHECK(worst <= 0.01);  // 0.0007 when written
}

TEST_CASE("the positions of the published readings are those of the protocol's table") {
    struct Row {
        Three p;
        Counts counts;
    };
    const Row row = GENERATE(values<Row>({{{0, 0, 0.08}, {-1284, -1284, -1284}},
                                          {{0, 0, 0.11}, {-516, -516, -516}},
                                          {{0, 0, 0.125}, {-200, -200, -200}},
                                          {{0, 0, 0.15}, {336, 336, 336}},
                                          {{0.02, 0.01, 0.12}, {-305, -554, 99}},
                                          {{-0.03, 0.02, 0.10}, {-1173, 73, -670}},
                                          {{0.03, -0.03, 0.14}, {829, -270, 335}},
                                          {{0, 0.04, 0.11}, {-1096, -119, 199}}}));
    CHECK(read_at(row.p) == row.counts);  // the truth itself
    pal_pose pose{};
    const pal_pose_config c = config();
    REQUIRE(pal_pose_step(&c, &PAL_DELTA_NF1, &pose, row.counts.data(), 0) == 0);
    for (std::size_t i = 0; i < 3; ++i)
        CHECK(std::abs(static_cast<double>(pose.position_m[i]) - row.p[i]) < 5.0e-5);  // a count
}

TEST_CASE("the velocity filter has the gain and lag of its difference equation, a low-pass at 50 Hz") {
    const double hz = GENERATE(2.0, 10.0, 25.0);
    const double amplitude_m = 0.05 / hz;  // 0.3 m/s at the peak
    const double omega = 2.0 * truth::PI * hz;
    pal_pose pose{};
    const pal_pose_config c = config();
    double in_phase = 0.0;
    double in_quadrature = 0.0;
    constexpr int N = 10000;  // whole periods
    for (int n = -1000; n < N; ++n) {
        const double t_s = n * 1e-3;
        const Counts counts = read_at({0.0, 0.0, 0.12 + amplitude_m * std::sin(omega * t_s)});
        REQUIRE(pal_pose_step(&c, &PAL_DELTA_NF1, &pose, counts.data(), 1000) == 0);
        if (n < 0) continue;
        in_phase += 2.0 / N * static_cast<double>(pose.velocity_m_per_s[2]) * std::cos(omega * t_s);
        in_quadrature += 2.0 / N * static_cast<double>(pose.velocity_m_per_s[2]) * std::sin(omega * t_s);
    }
    // v = a (1 - z^-1) / T / (1 - (1 - a) z^-1) of the positions, a = T / (T + 1 / (2 pi 50 Hz)).
    constexpr double T = 1e-3;
    const double a = T / (T + 1.0 / (2.0 * truth::PI * 50.0));
    const std::complex<double> back = std::exp(std::complex<double>(0.0, -omega * T));
    const std::complex<double> expected = a * (1.0 - back) / T / (1.0 - (1.0 - a) * back);
    const std::complex<double> got = omega * std::complex<double>(in_phase, -in_quadrature) *
                                     std::complex<double>(0.0, 1.0) / (amplitude_m * omega);
    CHECK(std::abs(got - expected) < 0.01 * std::abs(expected));
    CHECK(std::abs(got) / omega == Approx(1.0 / std::hypot(1.0, hz / 50.0)).epsilon(0.08));
}

TEST_CASE("the first position has no velocity, nor has one that was found anew") {
    pal_pose pose{};
    const pal_pose_config c = config();
    const Counts a = read_at({0.0, 0.0, 0.11});
    const Counts b = read_at({0.0, 0.0, 0.112});
    const Counts far = read_at({0.0, 0.03, 0.14});
    REQUIRE(pal_pose_step(&c, &PAL_DELTA_NF1, &pose, a.data(), 123456) == 0);
    CHECK(pose.velocity_m_per_s[2] == 0.0F);
    REQUIRE(pal_pose_step(&c, &PAL_DELTA_NF1, &pose, b.data(), 1000) == 0);
    CHECK(pose.velocity_m_per_s[2] > 0.1F);
    REQUIRE(pal_pose_step(&c, &PAL_DELTA_NF1, &pose, b.data(), 0) == 0);  // two replies at one time
    CHECK(std::isfinite(pose.velocity_m_per_s[2]));
    CHECK(pal_pose_step(&c, &PAL_DELTA_NF1, &pose, far.data(), 1000) == PAL_POSE_JUMP);
    CHECK(pose.has_position);
    CHECK(pose.position_m[1] == Approx(0.03).margin(5e-5));
    CHECK(pose.velocity_m_per_s[2] == 0.0F);
}

TEST_CASE("no readings, however wild, give a position that is not finite") {
    pal_pose pose{};
    const pal_pose_config c = config();
    std::uint32_t random = 1;
    int n_found = 0;
    for (int n = 0; n < 100000; ++n) {
        Counts counts{};
        for (std::int16_t& count : counts) {
            random = random * 1664525U + 1013904223U;
            const auto draw = static_cast<std::int16_t>(random >> 16U);
            count = n % 2 == 0 ? draw : static_cast<std::int16_t>(draw / 20);
        }
        const std::uint32_t faults = pal_pose_step(&c, &PAL_DELTA_NF1, &pose, counts.data(), random % 3000);
        REQUIRE(((faults & PAL_POSE_WORKSPACE) == 0) == pose.has_position);
        n_found += pose.has_position ? 1 : 0;
        for (int i = 0; i < 3; ++i) {
            REQUIRE(std::abs(pose.position_m[i]) < 0.3F);
            REQUIRE(std::isfinite(pose.velocity_m_per_s[i]));
        }
    }
    CHECK(n_found > 1000);
}

TEST_CASE("packets of both ways have the bytes of the protocol's examples") {
    using Packet = std::array<std::uint8_t, PAL_WIRE_BYTES>;
    const auto encode = [](Counts words, std::uint8_t flags) {
        pal_wire_request request{{words[0], words[1], words[2]}, flags};
        Packet packet{};
        pal_packet_encode(&request, packet.data());
        return packet;
    };
    CHECK(encode({0, 0, 0}, PAL_WIRE_HOMING | PAL_WIRE_RED) == Packet{0x3C, 0x41, 0x41, 0x41, 0x41, 0x41,
                                                                      0x41, 0x41, 0x41, 0x41, 0x41, 0x41,
                                                                      0x41, 0x4A, 0x41, 0x3E});
    CHECK(encode({-4095, 4095, -1}, PAL_WIRE_RED) == Packet{0x3C, 0x42, 0x41, 0x41, 0x50, 0x50, 0x50, 0x50,
                                                            0x41, 0x50, 0x50, 0x50, 0x50, 0x49, 0x41, 0x3E});
    // Captured from the maker's driver: 50 N inwards, blue.
    CHECK(encode({2752, 2780, 2888}, PAL_WIRE_BLUE) == Packet{0x3C, 0x41, 0x4D, 0x4B, 0x41, 0x4D, 0x4E, 0x4B,
                                                              0x41, 0x49, 0x45, 0x4C, 0x41, 0x45, 0x41,
                                                              0x3E});
    Packet in{0x3C, 0x4A, 0x46, 0x4B, 0x50, 0x41, 0x41, 0x41, 0x41, 0x42, 0x41, 0x41, 0x41, 0xB1, 0x41, 0x3E};
    pal_wire_reply reply{};
    REQUIRE(pal_packet_decode(in.data(), &reply));
    CHECK(reply.encoder_counts[0] == -1447);
    CHECK(reply.encoder_counts[1] == 0);
    CHECK(reply.encoder_counts[2] == 1);
    CHECK(reply.homed == 7);
    CHECK(reply.buttons == 0);
    Packet back{};
    pal_packet_encode_reply(&reply, back.data());
    CHECK(back == in);
    in[13] = 0xC0;
    REQUIRE(pal_packet_decode(in.data(), &reply));
    CHECK(reply.buttons == 15);
    pal_packet_encode_reply(&reply, back.data());
    CHECK(back[13] == 0xC0);
    reply.homed = 0xFF;  // no such arms
    pal_packet_encode_reply(&reply, back.data());
    CHECK(back[13] == 0xC0);
    in[13] = 0xC1;
    CHECK_FALSE(pal_packet_decode(in.data(), &reply));
}
