#include "common/table.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>

#include "common/err.h"
#include "tests/common/broken_tables.hpp"
#include "tests/common/tables.hpp"

using tables::Broken;
using tables::broken_tables;

TEST_CASE("every error has words of its own") {
    for (int a = PAL_ERR_IO; a <= 0; ++a) {
        for (int b = PAL_ERR_IO; b < a; ++b) {
            CHECK(std::string(pal_err_words(static_cast<pal_err>(a))) !=
                  pal_err_words(static_cast<pal_err>(b)));
        }
    }
}

TEST_CASE("a table of every size passes its check after it is sealed") {
    const auto n_nodes = GENERATE(as<std::uint32_t>{}, 5, 9, 17, 33, 65);
    const auto table = tables::make({}, n_nodes);
    const auto limits = tables::limits();
    CHECK(table->n_bytes == 156 + 12 * (n_nodes + 2) * (n_nodes + 2));
    CHECK(pal_table_check(table.get(), &limits) == PAL_OK);
    CHECK(pal_table_header_ok(table.get()));
}

TEST_CASE("table sizes outside the range have no bytes") {
    CHECK(pal_table_bytes(4) == 0);
    CHECK(pal_table_bytes(66) == 0);
    CHECK(pal_table_bytes(0xFFFFFFFFU) == 0);
    CHECK(pal_table_bytes(65) == sizeof(pal_table));
}

TEST_CASE("each kind of broken table is refused for its own reason") {
    const auto limits = tables::limits();
    for (const Broken& broken : broken_tables()) {
        INFO(broken.how);
        const auto table = tables::make();
        broken.breaking(*table);
        if (broken.sealed) pal_table_seal(table.get());
        CHECK(pal_table_check(table.get(), &limits) == broken.err);
    }
}

TEST_CASE("NaN and infinity are refused in every number of a table") {
    const float bad =
        GENERATE(as<float>{}, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                 -std::numeric_limits<float>::infinity());
    const auto limits = tables::limits();
    const auto words = [](const float& from, const pal_table& in) {
        return static_cast<std::size_t>(&from - &in.spacing_m);
    };
    const auto pattern = tables::make({}, 5);
    const std::size_t n_floats = words(pattern->coef[3 * 49], *pattern);
    for (std::size_t i = 0; i < n_floats; ++i) {
        if (i >= words(pattern->reserved[0], *pattern) && i < words(pattern->coef[0], *pattern)) continue;
        const auto table = tables::make({}, 5);
        std::memcpy(reinterpret_cast<char*>(table.get()) + offsetof(pal_table, spacing_m) + 4 * i, &bad,
                    sizeof bad);
        pal_table_seal(table.get());
        INFO("float " << i);
        CHECK(pal_table_check(table.get(), &limits) == PAL_ERR_NOT_FINITE);
    }
}

TEST_CASE("the tick's header check refuses what it can see") {
    for (const Broken& broken : broken_tables()) {
        const bool in_header = broken.err == PAL_ERR_MAGIC || broken.err == PAL_ERR_ENDIAN ||
                               broken.err == PAL_ERR_ABI || broken.err == PAL_ERR_SIZE ||
                               std::string(broken.how) == "id" || std::string(broken.how) == "law";
        if (!in_header) continue;
        INFO(broken.how);
        const auto table = tables::make();
        broken.breaking(*table);
        CHECK_FALSE(pal_table_header_ok(table.get()));
    }
}

TEST_CASE("every bit of a sealed table counts") {
    const auto limits = tables::limits();
    const auto table = tables::make({}, 5);
    auto* bytes = reinterpret_cast<unsigned char*>(table.get());
    for (std::uint32_t i = 0; i < table->n_bytes; ++i) {
        for (int bit = 0; bit < 8; ++bit) {
            bytes[i] = static_cast<unsigned char>(bytes[i] ^ (1U << bit));
            if (pal_table_check(table.get(), &limits) == PAL_OK) FAIL("byte " << i << " bit " << bit);
            bytes[i] = static_cast<unsigned char>(bytes[i] ^ (1U << bit));
        }
    }
    CHECK(pal_table_check(table.get(), &limits) == PAL_OK);
}
