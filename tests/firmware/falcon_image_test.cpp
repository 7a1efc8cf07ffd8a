#include "firmware/falcon/image.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "firmware/falcon/ftdi.h"
#include "tests/firmware/falcon_script.hpp"

namespace {

using script::Bytes;

// The smallest stream of docs/PROTOCOL.md 4: one word at the entry.
const Bytes SMALLEST{0xAA, 0x08, 0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0, 0, 0, 0,
                     0,    0x3F, 0x00, 0x02, 0x80, 0x01, 0x00, 0x3F, 0x00, 0x02, 0x80, 0x00, 0x00, 0, 0};

void put_block(Bytes& bytes, std::size_t n_words, std::uint32_t address) {
    for (const std::uint32_t word :
         {static_cast<std::uint32_t>(n_words), address >> 16U, address & 0xFFFFU}) {
        bytes.push_back(static_cast<std::uint8_t>(word));
        bytes.push_back(static_cast<std::uint8_t>(word >> 8U));
    }
    bytes.resize(bytes.size() + 2 * n_words, 0x5A);
}

// Blocks as the published grip firmware has them; the words mean nothing.
Bytes like_published() {
    Bytes bytes(SMALLEST.begin(), SMALLEST.begin() + 22);
    put_block(bytes, 3643, 0x3F8002);
    put_block(bytes, 241, 0x3F8E3D);
    put_block(bytes, 336, 0x0093A2);
    put_block(bytes, 2, 0x3F8000);
    bytes.resize(bytes.size() + 2, 0);
    return bytes;
}

pal_image_problem check(const Bytes& bytes, pal_image_info* info = nullptr) {
    return pal_image_check(bytes.data(), bytes.size(), info);
}

std::string sha(const Bytes& bytes) {
    std::array<std::uint8_t, PAL_SHA256_BYTES> digest{};
    pal_sha256(bytes.data(), bytes.size(), digest.data());
    std::string text = script::hex(digest.data(), digest.size());
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
    return text;
}

}  // namespace

TEST_CASE("the smallest boot container and one of the published layout are read to the last byte") {
    pal_image_info info{};
    REQUIRE(check(SMALLEST, &info) == PAL_IMAGE_OK);
    CHECK(info.entry == 0x3F8002);
    CHECK(info.n_blocks == 1);
    CHECK(info.n_words == 1);
    const Bytes big = like_published();
    REQUIRE(big.size() == 8492);  // as the published file has
    REQUIRE(check(big, &info) == PAL_IMAGE_OK);
    CHECK(info.n_blocks == 4);
    CHECK(info.n_words == 3643 + 241 + 336 + 2);
}

TEST_CASE("a container cut off anywhere is refused and the offset told") {
    const Bytes whole = like_published();
    for (std::size_t n = 0; n < whole.size(); ++n) {
        pal_image_info info{};
        const pal_image_problem problem = pal_image_check(whole.data(), n, &info);
        REQUIRE(problem == (n < 22 ? PAL_IMAGE_SHORT : PAL_IMAGE_CUT));
        REQUIRE(info.problem_at <= n);
    }
}

TEST_CASE("every way in which a container is broken has its name, its place and its words") {
    Bytes bytes = SMALLEST;
    pal_image_info info{};
    pal_image_problem expected = PAL_IMAGE_OK;
    std::uint32_t at = 0;
    SECTION("key") {
        bytes[GENERATE(0U, 1U)] ^= 0x01;
        expected = PAL_IMAGE_KEY;
    }
    SECTION("reserved words") {
        at = GENERATE(range(2U, 18U));
        bytes[at] = 1;
        expected = PAL_IMAGE_RESERVED;
    }
    SECTION("entry beyond the address bits") {
        bytes[18] = 0x40;
        at = 18;
        expected = PAL_IMAGE_ADDRESS;
    }
    SECTION("block beyond the address bits") {
        bytes[24] = 0x40;
        at = 24;
        expected = PAL_IMAGE_ADDRESS;
    }
    SECTION("block that ends beyond them") {
        bytes.resize(22);
        put_block(bytes, 2, 0x3FFFFF);
        bytes.resize(bytes.size() + 2, 0);
        at = 24;
        expected = PAL_IMAGE_ADDRESS;
    }
    SECTION("no block") {
        bytes.resize(22);
        bytes.resize(24, 0);
        at = 22;
        expected = PAL_IMAGE_EMPTY;
    }
    SECTION("bytes after the end mark") {
        at = static_cast<std::uint32_t>(bytes.size());
        bytes.push_back(0);
        expected = PAL_IMAGE_TRAILING;
    }
    SECTION("far too long") {
        bytes.resize(PAL_IMAGE_BYTES_MAX + 1, 0);
        at = PAL_IMAGE_BYTES_MAX;
        expected = PAL_IMAGE_LONG;
    }
    CHECK(check(bytes, &info) == expected);
    CHECK(info.problem_at == at);
    CHECK(std::string(pal_image_words(expected)).size() > 20);
}

TEST_CASE("digests are those of FIPS 180-4's examples, at every length around a block's end") {
    const auto text = [](const std::string& s) { return Bytes(s.begin(), s.end()); };
    CHECK(sha({}) == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    CHECK(sha(text("abc")) == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    CHECK(sha(text("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq")) ==
          "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    CHECK(sha(Bytes(1000000, 'a')) == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
    CHECK(sha(Bytes(55, 'a')) == "9f4390f8d30c2dd92ec9f095b65e2b9ae9b0a925a5258e241c9f1e910f734318");
    CHECK(sha(Bytes(56, 'a')) == "b35439a4ac6f0948b6d6f9e3c6af0f5f590ce20f1bde7090ef7970686ec6738a");
    CHECK(sha(Bytes(63, 'a')) == "7d3e74a05d7db15bce4ad9ec0658ea98e3f06eeecf16b4c6fff2da457ddc2f34");
    CHECK(sha(Bytes(64, 'a')) == "ffe054fe7ae0cb6dc65c3af9b61d5209f439851db43d0ba5997337df154668eb");
}

TEST_CASE("published images are known by their digest, others are not") {
    std::array<std::uint8_t, PAL_SHA256_BYTES> digest{
        0x11, 0x19, 0xe3, 0x9c, 0x39, 0xfa, 0xb1, 0xf3, 0x76, 0x78, 0xea, 0x62, 0xdf, 0xc7, 0x15, 0xb2,
        0x3d, 0xd8, 0x6e, 0xe7, 0xf1, 0x3d, 0x78, 0xf8, 0x8f, 0x70, 0x7d, 0x9f, 0x09, 0xb8, 0x96, 0xa1};
    REQUIRE(pal_image_name(digest.data()) != nullptr);
    CHECK(std::string(pal_image_name(digest.data())) == "nvent_firmware.bin");
    digest[31] ^= 1;
    CHECK(pal_image_name(digest.data()) == nullptr);
}

TEST_CASE("baud divisors are those of the bridge's table") {
    struct Row {
        std::uint32_t asked, real;
        int value, index;
    };
    const Row row = GENERATE(values<Row>({{9600, 9600, 0x4138, 0},
                                          {142857, 142857, 0x0015, 0},
                                          {140000, 140351, 0x0015, 1},
                                          {1500000, 1500000, 0x0002, 0},
                                          {1456312, 1500000, 0x0002, 0},
                                          {115200, 115385, 0x001A, 0},
                                          {57600, 57554, 0xC034, 0},
                                          {38400, 38400, 0xC04E, 0},
                                          {3000000, 3000000, 0, 0},
                                          {2000000, 2000000, 1, 0},
                                          {9000000, 3000000, 0, 0}}));
    const pal_usb_step step = pal_ftdi_baud(row.asked);
    CHECK(step.kind == PAL_USB_CONTROL);
    CHECK(step.request == 0x03);
    CHECK(step.value == row.value);
    CHECK(step.index == row.index);
    CHECK(pal_ftdi_real_baud(row.asked) == row.real);
    CHECK(pal_ftdi_real_baud(0) == 184);  // the slowest that 14 bits of divisor hold
}

TEST_CASE("every packet of a transfer loses its two status bytes, at 0, 64, 128") {
    for (std::size_t n = 0; n <= 200; ++n) {
        Bytes transfer(n);
        for (std::size_t i = 0; i < n; ++i) transfer[i] = static_cast<std::uint8_t>(i);
        Bytes expected;
        for (std::size_t i = 0; i < n; ++i) {
            if (i % 64 >= 2) expected.push_back(static_cast<std::uint8_t>(i));
        }
        Bytes got;
        std::size_t n_taken = 0;
        std::size_t n_packets = 0;
        pal_ftdi_payload payload;
        while (pal_ftdi_next_packet(transfer.data(), n, &n_taken, &payload)) {
            got.insert(got.end(), payload.bytes, payload.bytes + payload.n_bytes);
            n_packets += 1;
        }
        REQUIRE(got == expected);
        REQUIRE(n_packets == (n + 63) / 64);
    }
}

TEST_CASE("line errors are told from the idle state of the line") {
    const Bytes idle{0x01, 0x60};
    const Bytes overrun{0x01, 0x62, 0x41};
    std::size_t n_taken = 0;
    pal_ftdi_payload payload;
    REQUIRE(pal_ftdi_next_packet(idle.data(), idle.size(), &n_taken, &payload));
    CHECK(payload.line_errors == 0);
    n_taken = 0;
    REQUIRE(pal_ftdi_next_packet(overrun.data(), overrun.size(), &n_taken, &payload));
    CHECK(payload.line_errors == PAL_FTDI_OVERRUN);
}
