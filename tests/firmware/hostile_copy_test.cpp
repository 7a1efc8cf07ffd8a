// What a look-up checked is what it uses: lookup.c, the shipped file, with a writer that spoils the header
// right behind the one copy that is made of it.
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <random>

#include "common/atomic.h"
#include "firmware/core/intake.h"
#include "firmware/core/lookup.h"
#include "tests/firmware/hostile_bench.hpp"

namespace {

pal_table* spoilt = nullptr;  ///< table whose header is overwritten after each copy
std::uint8_t filling = 0;
int n_copies = 0;
pal_table* renamed = nullptr;  ///< table whose id is overwritten before the copy of this number, from 1
int renamed_at = 0;

pal_touch touch(const pal_table& table, const std::array<float, 3>& at_m) {
    pal_touch out;
    pal_table_touch(&table, at_m.data(), &out);
    return out;
}

}  // namespace

extern "C" {
void pal_copy_once(void* copy, const void* shared, std::size_t n_bytes) {
    ++n_copies;
    if (renamed != nullptr && n_copies == renamed_at) renamed->id = 1ULL << 60U;
    std::memcpy(copy, shared, n_bytes);
    if (spoilt != nullptr) std::memset(static_cast<void*>(spoilt), filling, offsetof(pal_table, coef));
}
std::uint32_t pal_atomic_load_acquire(const std::uint32_t* word) {
    return *word;
}
void pal_atomic_store_release(std::uint32_t* word, std::uint32_t value) {
    *word = value;
}
void pal_note_read(const void*) {}
void pal_note_write(const void*) {}
}

TEST_CASE("a header spoilt after its copy changes not one bit of a look-up") {
    filling = GENERATE(as<std::uint8_t>{}, 0x00, 0xFF, 0x7F, 0x3F, 0x01);
    const auto good = hostile::uneven(1);
    const auto table = std::make_unique<pal_table>();
    std::mt19937 random(4);
    std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
    int n_pressed = 0;
    for (int n = 0; n < 2000; ++n) {
        const std::array<float, 3> at_m = {8e-3F * unit(random), 8e-3F * unit(random), 5e-3F * unit(random)};
        spoilt = nullptr;
        const pal_touch expected = touch(*good, at_m);
        *table = *good;
        spoilt = table.get();
        n_copies = 0;
        const pal_touch felt = touch(*table, at_m);
        REQUIRE(n_copies == 1);
        REQUIRE(table->n_nodes != good->n_nodes);
        REQUIRE(std::memcmp(felt.force_n, expected.force_n, sizeof felt.force_n) == 0);
        REQUIRE(felt.potential_j == expected.potential_j);
        REQUIRE(felt.depth_m == expected.depth_m);
        REQUIRE(felt.k_n_per_m == expected.k_n_per_m);
        REQUIRE(felt.inside == expected.inside);
        n_pressed += felt.potential_j > 0.0F ? 1 : 0;
    }
    CHECK(n_pressed > 500);
}

TEST_CASE("a look-up checks its own copy: sizes beyond the table's bounds give no answer") {
    spoilt = nullptr;
    const auto n_nodes = GENERATE(as<std::uint32_t>{}, 0, 1, 4, 66, 67, 1000, 0x7FFFFFFF, 0xFFFFFFFF);
    const auto table = hostile::uneven(1);
    table->n_nodes = n_nodes;
    CHECK_FALSE(touch(*table, {0.0F, 0.0F, -1e-3F}).inside);
}

TEST_CASE("an id spoilt while its table is checked does not shut out the tables after it") {
    const auto ring = std::make_unique<pal_table_ring>();
    pal_table_ring_init(ring.get());
    pal_intake intake{};
    intake.ring = ring.get();
    intake.limits = pal_table_limits_default();
    const auto round = [&](std::uint64_t id, int spoil_at) {
        const auto table = hostile::uneven(id);
        renamed = pal_table_ring_back(ring.get());
        std::memcpy(renamed, table.get(), table->n_bytes);
        pal_table_ring_publish(ring.get());
        pal_intake_poll(&intake, false);
        n_copies = 0;
        renamed_at = spoil_at;
        pal_intake_check(&intake);
        renamed = nullptr;
        return pal_intake_poll(&intake, false);
    };
    spoilt = nullptr;
    REQUIRE(round(1, 0)->now != nullptr);
    const int spoil_at = GENERATE(1, 2);
    CHECK(round(2, spoil_at)->n_bad == 1);
    CHECK(intake.now_id == 1);
    CHECK(round(3, 0)->n_bad == 1);
    CHECK(intake.now_id == 3);
}
