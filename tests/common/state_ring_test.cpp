#include "common/state_ring.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <memory>
#include <random>
#include <thread>

namespace {

std::unique_ptr<pal_state_ring> make_ring() {
    auto ring = std::make_unique<pal_state_ring>();
    pal_state_ring_init(ring.get());
    return ring;
}

/// Every word a function of `n`, so that a mixture of two records shows.
pal_tick make_tick(std::uint32_t n) {
    std::uint32_t words[PAL_TICK_WORDS];
    for (std::uint32_t i = 0; i < PAL_TICK_WORDS; ++i) words[i] = n * 2654435761U + i;
    pal_tick tick;
    std::memcpy(&tick, words, sizeof tick);
    return tick;
}

bool same(const pal_tick& a, const pal_tick& b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

}  // namespace

TEST_CASE("records come out in order and unchanged") {
    const auto ring = make_ring();
    pal_state_reader reader{};
    pal_tick tick;
    CHECK_FALSE(pal_state_ring_read(ring.get(), &reader, &tick));
    for (std::uint32_t n = 0; n < 3 * PAL_STATE_RING_TICKS; ++n) {
        const pal_tick in = make_tick(n);
        pal_state_ring_push(ring.get(), &in);
        REQUIRE(pal_state_ring_waiting(ring.get(), &reader) == 1);
        REQUIRE(pal_state_ring_read(ring.get(), &reader, &tick));
        REQUIRE(same(tick, in));
    }
    CHECK(reader.n_dropped == 0);
}

TEST_CASE("a slow reader loses the oldest records and is told how many") {
    const auto ring = make_ring();
    pal_state_reader reader{};
    constexpr std::uint32_t N_LOST = 37;
    for (std::uint32_t n = 0; n < PAL_STATE_RING_TICKS + N_LOST; ++n) {
        const pal_tick in = make_tick(n);
        pal_state_ring_push(ring.get(), &in);
    }
    CHECK(pal_state_ring_waiting(ring.get(), &reader) == PAL_STATE_RING_TICKS);
    pal_tick tick;
    for (std::uint32_t n = N_LOST; n < PAL_STATE_RING_TICKS + N_LOST; ++n) {
        REQUIRE(pal_state_ring_read(ring.get(), &reader, &tick));
        REQUIRE(same(tick, make_tick(n)));
    }
    CHECK(reader.n_dropped == N_LOST);
    CHECK_FALSE(pal_state_ring_read(ring.get(), &reader, &tick));
}

TEST_CASE("the ring works across the wrap of its counters") {
    const auto ring = make_ring();
    pal_state_reader reader{};
    ring->begun = ring->done = reader.next = 0xFFFFFFF0U;
    pal_tick tick;
    for (std::uint32_t n = 0; n < 64; ++n) {
        const pal_tick in = make_tick(n);
        pal_state_ring_push(ring.get(), &in);
    }
    for (std::uint32_t n = 0; n < 64; ++n) {
        REQUIRE(pal_state_ring_read(ring.get(), &reader, &tick));
        REQUIRE(same(tick, make_tick(n)));
    }
    CHECK(reader.n_dropped == 0);
}

TEST_CASE("a record that is being overwritten is not handed out") {
    const auto ring = make_ring();
    for (std::uint32_t n = 0; n < PAL_STATE_RING_TICKS; ++n) {
        const pal_tick in = make_tick(n);
        pal_state_ring_push(ring.get(), &in);
    }
    // The writer died in the middle of record 4096: begun is announced, some words of slot 0 are new.
    ring->begun += 1U;
    std::memset(ring->word[0], 0xAA, 100);
    pal_state_reader reader{};
    pal_tick tick;
    REQUIRE(pal_state_ring_read(ring.get(), &reader, &tick));
    CHECK(reader.n_dropped > 0);
    CHECK(same(tick, make_tick(reader.n_dropped)));
}

TEST_CASE("garbage in begun and done: every call ends within the ring, and the next records mend it") {
    const auto ring = make_ring();
    std::mt19937 random(7);
    const auto word = [&random] {
        const auto any = static_cast<std::uint32_t>(random());
        return random() % 2 == 0 ? any : any % (3 * PAL_STATE_RING_TICKS);
    };
    for (int n = 0; n < 20000; ++n) {
        ring->begun = word();
        ring->done = random() % 4 == 0 ? ring->begun : word();
        pal_state_reader reader{.next = word(), .n_dropped = 0};
        pal_tick tick;
        for (int i = 0; i < 4; ++i) (void)pal_state_ring_read(ring.get(), &reader, &tick);
        REQUIRE(pal_state_ring_waiting(ring.get(), &reader) <= PAL_STATE_RING_TICKS);
        const std::uint32_t first = ring->done;
        for (std::uint32_t i = 0; i < 3; ++i) {
            const pal_tick in = make_tick(first + i);
            pal_state_ring_push(ring.get(), &in);
        }
        CHECK(ring->done == first + 3);
        CHECK(ring->begun == first + 3);
        reader.next = first;
        for (std::uint32_t i = 0; i < 3; ++i) {
            REQUIRE(pal_state_ring_read(ring.get(), &reader, &tick));
            REQUIRE(same(tick, make_tick(first + i)));
        }
    }
}

TEST_CASE("while begun and done contradict each other a reader stays where it is") {
    const auto ring = make_ring();
    for (std::uint32_t n = 0; n < 10; ++n) {
        const pal_tick in = make_tick(n);
        pal_state_ring_push(ring.get(), &in);
    }
    pal_state_reader reader{.next = 4, .n_dropped = 0};
    pal_tick tick;
    SECTION("done ran ahead") {
        ring->done = 5000;
    }
    SECTION("begun fell behind") {
        ring->begun = 2;
    }
    SECTION("begun ran ahead") {
        ring->begun = 0x80000000U;
    }
    CHECK_FALSE(pal_state_ring_read(ring.get(), &reader, &tick));
    CHECK(reader.next == 4);
    CHECK(reader.n_dropped == 0);
}

TEST_CASE("two threads: every record is whole and read plus dropped is all", "[concurrency]") {
    const auto ring = make_ring();
    constexpr std::uint32_t N_TICKS = 200000;
    std::thread writer([&ring] {
        for (std::uint32_t n = 0; n < N_TICKS; ++n) {
            const pal_tick in = make_tick(n);
            pal_state_ring_push(ring.get(), &in);
        }
    });
    pal_state_reader reader{};
    pal_tick tick;
    std::uint32_t n_read = 0;
    bool ok = true;
    while (reader.next != N_TICKS) {
        if (!pal_state_ring_read(ring.get(), &reader, &tick)) continue;
        ok = ok && same(tick, make_tick(reader.next - 1U));
        ++n_read;
    }
    writer.join();
    CHECK(ok);
    CHECK(n_read + reader.n_dropped == N_TICKS);
}
