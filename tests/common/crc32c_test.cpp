#include "common/crc32c.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <random>
#include <vector>

namespace {

/// By the definition, bit by bit.
std::uint32_t bitwise(const unsigned char* bytes, std::size_t n_bytes) {
    std::uint32_t crc = 0xFFFFFFFFU;
    for (std::size_t i = 0; i < n_bytes; ++i) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0U ? 0x82F63B78U : 0U);
    }
    return ~crc;
}

}  // namespace

TEST_CASE("CRC-32C gives the published check values") {
    CHECK(pal_crc32c("123456789", 9) == 0xE3069283U);
    CHECK(pal_crc32c("", 0) == 0U);
    // RFC 3720, B.4; the RFC writes the bytes in the order in which they are sent, lowest first.
    std::array<unsigned char, 32> bytes{};
    CHECK(pal_crc32c(bytes.data(), bytes.size()) == 0x8A9136AAU);
    bytes.fill(0xFF);
    CHECK(pal_crc32c(bytes.data(), bytes.size()) == 0x62A8AB43U);
    for (std::size_t i = 0; i < 32; ++i) bytes[i] = static_cast<unsigned char>(i);
    CHECK(pal_crc32c(bytes.data(), bytes.size()) == 0x46DD794EU);
    for (std::size_t i = 0; i < 32; ++i) bytes[i] = static_cast<unsigned char>(31 - i);
    CHECK(pal_crc32c(bytes.data(), bytes.size()) == 0x113FDB5CU);
    const std::array<unsigned char, 48> read_command = {
        0x01, 0xC0, 0, 0,    0, 0, 0, 0,    0,    0, 0, 0, 0, 0, 0, 0, 0x14, 0, 0, 0, 0, 0, 4, 0,
        0,    0,    0, 0x14, 0, 0, 0, 0x18, 0x28, 0, 0, 0, 0, 0, 0, 0, 2,    0, 0, 0, 0, 0, 0, 0};
    CHECK(pal_crc32c(read_command.data(), read_command.size()) == 0xD9963A56U);
}

TEST_CASE("any length from any address has the CRC of the definition") {
    std::mt19937 random(3720);
    std::vector<unsigned char> bytes(128);
    for (unsigned char& byte : bytes) byte = static_cast<unsigned char>(random());
    for (std::size_t from = 0; from < 8; ++from) {
        for (std::size_t n = 0; from + n <= bytes.size(); ++n) {
            REQUIRE(pal_crc32c(bytes.data() + from, n) == bitwise(bytes.data() + from, n));
        }
    }
}

TEST_CASE("every byte value at every place of the eight that are taken together counts as it should") {
    for (std::size_t place = 0; place < 8; ++place) {
        for (int value = 0; value < 256; ++value) {
            std::array<unsigned char, 8> bytes{};
            bytes[place] = static_cast<unsigned char>(value);
            REQUIRE(pal_crc32c(bytes.data(), bytes.size()) == bitwise(bytes.data(), bytes.size()));
        }
    }
}

TEST_CASE("the CRC of a whole is that of its pieces in turn, however it is cut") {
    std::mt19937 random(3385);
    std::vector<unsigned char> bytes(61);
    for (unsigned char& byte : bytes) byte = static_cast<unsigned char>(random());
    const std::uint32_t whole = bitwise(bytes.data(), bytes.size());
    for (std::size_t a = 0; a <= bytes.size(); ++a) {
        for (std::size_t b = a; b <= bytes.size(); ++b) {
            std::uint32_t crc = pal_crc32c(bytes.data(), a);
            crc = pal_crc32c_more(crc, bytes.data() + a, b - a);
            REQUIRE(pal_crc32c_more(crc, bytes.data() + b, bytes.size() - b) == whole);
        }
    }
    CHECK(pal_crc32c_more(0, bytes.data(), bytes.size()) == whole);
}
