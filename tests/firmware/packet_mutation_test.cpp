// Replies under mutation: nothing that is no reply is taken for one, and the stream is found again at once.
// 200 000 bytes; 10 million with PALPATE_SOAK.
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <vector>

#include "firmware/falcon/packet.h"

namespace {

using Bytes = std::vector<std::uint8_t>;
using Random = std::mt19937_64;

std::size_t n_bytes_wanted() {
    return std::getenv("PALPATE_SOAK") != nullptr ? 10000000 : 200000;
}

struct Reply {
    std::int16_t counts[3];
    std::uint8_t flags;  // homed and buttons, 7 bits
    bool operator==(const Reply&) const = default;
};

/// By the rules of docs/PROTOCOL.md 4, not by the code under test.
Bytes bytes_of(const Reply& reply, std::uint8_t spare) {
    Bytes bytes{0x3C};
    for (const std::int16_t count : reply.counts) {
        for (int k = 0; k < 4; ++k)
            bytes.push_back(
                static_cast<std::uint8_t>('A' + ((static_cast<std::uint16_t>(count) >> (4 * k)) & 15)));
    }
    bytes.push_back(static_cast<std::uint8_t>('A' + reply.flags));
    bytes.push_back(spare);
    bytes.push_back(0x3E);
    return bytes;
}

/// What the rules say about 16 bytes.
bool is_reply(const std::uint8_t* bytes) {
    bool good = bytes[0] == 0x3C && bytes[15] == 0x3E && bytes[13] >= 0x41 && bytes[13] <= 0xC0;
    for (int i = 1; i <= 12; ++i) good = good && bytes[i] >= 'A' && bytes[i] <= 'P';
    return good;
}

Reply random_reply(Random& random) {
    Reply reply{};
    for (std::int16_t& count : reply.counts) count = static_cast<std::int16_t>(random());
    reply.flags = static_cast<std::uint8_t>(random() % 128);
    return reply;
}

void mutate(Bytes& bytes, Random& random) {
    const std::size_t at = random() % bytes.size();
    const auto byte = static_cast<std::uint8_t>(random());
    const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    switch (random() % 6) {
        case 0:
            *place = byte;
            break;
        case 1:
            *place = static_cast<std::uint8_t>(*place ^ (1U << random() % 8));
            break;
        case 2:
            bytes.erase(place);
            break;
        case 3:
            bytes.insert(place, byte);
            break;
        case 4:
            *place = random() % 2 == 0 ? 0x3C : 0x3E;
            break;
        default:
            bytes.erase(place, bytes.end());  // the rest is lost
            break;
    }
    if (bytes.empty()) bytes.push_back(byte);
}

struct Taken {
    std::vector<Reply> replies;
    std::size_t n_bytes = 0;
};

void feed(pal_wire_reader& reader, const Bytes& bytes, Taken& taken) {
    for (const std::uint8_t byte : bytes) {
        ++taken.n_bytes;
        if (!pal_wire_feed(&reader, byte)) continue;
        pal_wire_reply reply{};
        const bool accepted = pal_packet_decode(reader.bytes, &reply);
        if (accepted != is_reply(reader.bytes)) FAIL("a reply was taken, or refused, against the rules");
        if (!accepted) continue;
        taken.replies.push_back({{reply.encoder_counts[0], reply.encoder_counts[1], reply.encoder_counts[2]},
                                 static_cast<std::uint8_t>(reply.homed << 4U | reply.buttons)});
    }
}

}  // namespace

TEST_CASE("among mutated bytes no reply is taken that is none, and the second good one is always there") {
    Random random(1);
    pal_wire_reader reader{};
    std::size_t n_bytes = 0;
    std::size_t n_first_lost = 0;
    while (n_bytes < n_bytes_wanted()) {
        Taken taken;
        const std::size_t n_mutated = 1 + random() % 4;
        for (std::size_t i = 0; i < n_mutated; ++i) {
            Bytes bytes = bytes_of(random_reply(random), static_cast<std::uint8_t>(0x41 + random() % 16));
            for (std::size_t k = random() % 4; k > 0; --k) mutate(bytes, random);
            feed(reader, bytes, taken);
        }
        const std::size_t n_before = taken.replies.size();
        const Reply first = random_reply(random), second = random_reply(random), third = random_reply(random);
        for (const Reply& reply : {first, second, third}) feed(reader, bytes_of(reply, 0x41), taken);
        REQUIRE(taken.replies.size() >= n_before + 2);
        REQUIRE(taken.replies.end()[-1] == third);
        REQUIRE(taken.replies.end()[-2] == second);
        n_first_lost += taken.replies.size() < n_before + 3 || taken.replies.end()[-3] != first;
        n_bytes += taken.n_bytes;
    }
    CHECK(n_first_lost == 0);  // '<' occurs in no payload: even the first one is there
}
