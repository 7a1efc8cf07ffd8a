#include "common/table_ring.h"

#include <catch2/catch.hpp>
#include <memory>
#include <random>
#include <set>
#include <thread>

namespace {

std::unique_ptr<pal_table_ring> make_ring() {
    auto ring = std::make_unique<pal_table_ring>();
    pal_table_ring_init(ring.get());
    return ring;
}

bool is_permutation_of_slots(const pal_table_ring& ring) {
    const std::uint32_t s = ring.state;
    return std::set<std::uint32_t>{s & 3U, s >> 2 & 3U, s >> 4 & 3U, s >> 6 & 3U}.size() == 4;
}

void fill(pal_table& table, std::uint64_t id) {
    table.id = id;
    for (std::size_t i = 0; i < PAL_TABLE_COEFS_MAX; ++i) {
        table.coef[i] = static_cast<float>((id * 31 + i) % 8388607);
    }
}

bool is_whole(const pal_table& table) {
    for (std::size_t i = 0; i < PAL_TABLE_COEFS_MAX; ++i) {
        if (table.coef[i] != static_cast<float>((table.id * 31 + i) % 8388607)) return false;
    }
    return true;
}

}  // namespace

TEST_CASE("an empty ring gives no table") {
    const auto ring = make_ring();
    CHECK(is_permutation_of_slots(*ring));
    CHECK_FALSE(pal_table_ring_take(ring.get()));
    CHECK_FALSE(pal_table_ring_replace(ring.get()));
    CHECK_FALSE(pal_table_header_ok(pal_table_ring_current(ring.get())));
}

TEST_CASE("the reader gets the newest table and keeps the one before it") {
    const auto ring = make_ring();
    for (std::uint64_t id = 1; id <= 3; ++id) {
        pal_table_ring_back(ring.get())->id = id;
        pal_table_ring_publish(ring.get());
    }
    REQUIRE(pal_table_ring_take(ring.get()));
    CHECK(pal_table_ring_current(ring.get())->id == 3);
    CHECK_FALSE(pal_table_ring_take(ring.get()));
    pal_table_ring_back(ring.get())->id = 4;
    pal_table_ring_publish(ring.get());
    REQUIRE(pal_table_ring_take(ring.get()));
    CHECK(pal_table_ring_current(ring.get())->id == 4);
    CHECK(pal_table_ring_previous(ring.get())->id == 3);
}

TEST_CASE("replacing gives the current table back and leaves the previous one") {
    const auto ring = make_ring();
    for (std::uint64_t id = 1; id <= 2; ++id) {
        pal_table_ring_back(ring.get())->id = id;
        pal_table_ring_publish(ring.get());
        REQUIRE(pal_table_ring_take(ring.get()));
    }
    pal_table_ring_back(ring.get())->id = 3;
    pal_table_ring_publish(ring.get());
    REQUIRE(pal_table_ring_replace(ring.get()));
    CHECK(pal_table_ring_current(ring.get())->id == 3);
    CHECK(pal_table_ring_previous(ring.get())->id == 1);
}

TEST_CASE("the four slots stay a permutation and no side's slot moves under random use") {
    const auto ring = make_ring();
    std::mt19937 random(20240611);
    std::uint64_t published = 0;
    std::uint64_t current = 0;
    std::uint64_t previous = 0;
    for (int n = 0; n < 200000; ++n) {
        const pal_table* back = pal_table_ring_back(ring.get());
        const auto choice = random() % 4;
        if (choice < 2) {
            pal_table_ring_back(ring.get())->id = ++published;
            pal_table_ring_publish(ring.get());
        } else if (choice == 2) {
            if (pal_table_ring_take(ring.get())) {
                previous = current;
                current = published;
            }
            REQUIRE(pal_table_ring_back(ring.get()) == back);
        } else {
            if (pal_table_ring_replace(ring.get())) current = published;
            REQUIRE(pal_table_ring_back(ring.get()) == back);
        }
        REQUIRE(is_permutation_of_slots(*ring));
        REQUIRE(pal_table_ring_current(ring.get())->id == current);
        REQUIRE(pal_table_ring_previous(ring.get())->id == previous);
        REQUIRE(pal_table_ring_back(ring.get()) != pal_table_ring_current(ring.get()));
        REQUIRE(pal_table_ring_back(ring.get()) != pal_table_ring_previous(ring.get()));
    }
}

TEST_CASE("a table that is published before it is filled is seen to be torn") {
    const auto ring = make_ring();
    pal_table* back = pal_table_ring_back(ring.get());
    fill(*back, 1);
    back->id = 2;  // the mutant: the words of 1 under the id of 2
    pal_table_ring_publish(ring.get());
    REQUIRE(pal_table_ring_take(ring.get()));
    CHECK_FALSE(is_whole(*pal_table_ring_current(ring.get())));
}

TEST_CASE("a state word that is no permutation is acted on by neither side and left as it is") {
    const auto ring = make_ring();
    int n_whole = 0;
    for (std::uint32_t low = 0; low < 512; ++low) {
        for (const std::uint32_t count : {0U, 1U, 0x7FFFFFU}) {
            const std::uint32_t word = low | count << 9U;
            ring->state = word;
            if (is_permutation_of_slots(*ring)) {
                ++n_whole;
                CHECK(pal_table_ring_back(ring.get()) == &ring->slot[word >> 6U & 3U].table);
                CHECK(pal_table_ring_publish(ring.get()));
                continue;
            }
            CHECK(pal_table_ring_back(ring.get()) == nullptr);
            CHECK_FALSE(pal_table_ring_publish(ring.get()));
            CHECK_FALSE(pal_table_ring_take(ring.get()));
            CHECK_FALSE(pal_table_ring_replace(ring.get()));
            CHECK(pal_table_ring_current(ring.get()) == &ring->slot[word >> 2U & 3U].table);
            CHECK(pal_table_ring_previous(ring.get()) == &ring->slot[word & 3U].table);
            CHECK(ring->state == word);
        }
    }
    CHECK(n_whole == 24 * 2 * 3);
}

TEST_CASE("two threads: no torn table, ids only grow, the previous table stays whole", "[concurrency]") {
    const auto ring = make_ring();
    constexpr std::uint64_t N_TABLES = 3000;
    std::thread writer([&ring] {
        for (std::uint64_t id = 1; id <= N_TABLES; ++id) {
            fill(*pal_table_ring_back(ring.get()), id);
            pal_table_ring_publish(ring.get());
        }
    });
    std::uint64_t last = 0;
    std::uint64_t n_taken = 0;
    bool ok = true;
    while (last < N_TABLES) {
        if (!pal_table_ring_take(ring.get())) continue;
        ++n_taken;
        const pal_table* now = pal_table_ring_current(ring.get());
        const pal_table* before = pal_table_ring_previous(ring.get());
        ok = ok && now->id > last && is_whole(*now) && before->id == last && (last == 0 || is_whole(*before));
        last = now->id;
    }
    writer.join();
    CHECK(ok);
    CHECK(n_taken > 0);
    CHECK(is_permutation_of_slots(*ring));
}
