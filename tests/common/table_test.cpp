#include "common/table.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "common/err.h"
#include "tests/common/tables.hpp"

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

namespace {

struct Broken {
    const char* how;
    pal_err err;
    bool sealed;  // sealed again afterwards, so that only the number itself is wrong
    std::function<void(pal_table&)> breaking;
};

constexpr std::uint32_t SIDE = 35, PLANE = SIDE * SIDE;

std::vector<Broken> broken_tables() {
    return {
        {"magic", PAL_ERR_MAGIC, false, [](pal_table& t) { t.magic ^= 1U; }},
        {"byte order", PAL_ERR_ENDIAN, false, [](pal_table& t) { t.magic = 0x5441424CU; }},
        {"abi", PAL_ERR_ABI, false, [](pal_table& t) { t.abi = 2; }},
        {"too few nodes", PAL_ERR_SIZE, true, [](pal_table& t) { t.n_nodes = 3; }},
        {"even nodes", PAL_ERR_SIZE, true, [](pal_table& t) { t.n_nodes = 32; }},
        {"too many nodes", PAL_ERR_SIZE, true, [](pal_table& t) { t.n_nodes = 67; }},
        {"huge nodes", PAL_ERR_SIZE, false, [](pal_table& t) { t.n_nodes = 0x80000000U; }},
        {"n_bytes", PAL_ERR_SIZE, false, [](pal_table& t) { t.n_bytes += 4; }},
        {"crc", PAL_ERR_CRC, false, [](pal_table& t) { t.crc32c ^= 1U; }},
        {"a flipped bit", PAL_ERR_CRC, false, [](pal_table& t) { t.coef[7] += 1.0e-6F; }},
        {"id", PAL_ERR_RANGE, true, [](pal_table& t) { t.id = 0; }},
        {"law", PAL_ERR_RANGE, true, [](pal_table& t) { t.law = 2; }},
        {"no spacing", PAL_ERR_RANGE, true, [](pal_table& t) { t.spacing_m = 0.0F; }},
        {"negative spacing", PAL_ERR_RANGE, true, [](pal_table& t) { t.spacing_m = -1.0e-3F; }},
        {"valid beyond the nodes", PAL_ERR_RANGE, true, [](pal_table& t) { t.valid_radius_m = 0.0101F; }},
        {"no valid radius", PAL_ERR_RANGE, true, [](pal_table& t) { t.valid_radius_m = 0.0F; }},
        {"curvature", PAL_ERR_RANGE, true, [](pal_table& t) { t.kappa_per_m = 1.0e5F; }},
        {"error below zero", PAL_ERR_RANGE, true, [](pal_table& t) { t.error_k_relative = -0.1F; }},
        {"no depth scale", PAL_ERR_RANGE, true, [](pal_table& t) { t.depth_scale_m = 0.0F; }},
        {"psi with a pole", PAL_ERR_RANGE, true, [](pal_table& t) { t.psi[3] = -0.5F; }},
        {"psi with a pole far out", PAL_ERR_RANGE, true, [](pal_table& t) { t.psi[4] = -1.0e-3F; }},
        {"psi that pulls", PAL_ERR_RANGE, true, [](pal_table& t) { t.psi[0] = -0.5F; }},
        {"psi that pulls at 0.1 only", PAL_ERR_RANGE, true,
         [](pal_table& t) {
             t.psi[0] = -20.0F;
             t.psi[1] = 95.0F;
         }},
        {"place", PAL_ERR_RANGE, true, [](pal_table& t) { t.p0_m[1] = 5.0F; }},
        {"stretched axis", PAL_ERR_RANGE, true, [](pal_table& t) { t.axes[0] = 1.01F; }},
        {"skew axes", PAL_ERR_RANGE, true, [](pal_table& t) { t.axes[1] = 0.01F; }},
        {"no stiffness", PAL_ERR_RANGE, true, [](pal_table& t) { t.coef[PLANE + 40] = 0.0F; }},
        {"negative stiffness", PAL_ERR_RANGE, true, [](pal_table& t) { t.coef[PLANE + 40] = -1.0F; }},
        {"too stiff", PAL_ERR_RANGE, true, [](pal_table& t) { t.coef[2 * PLANE - 1] = 6001.0F; }},
        {"stiffness jumps", PAL_ERR_RANGE, true, [](pal_table& t) { t.coef[PLANE + 40] = 3000.0F; }},
        {"surface jumps", PAL_ERR_RANGE, true, [](pal_table& t) { t.coef[40] = 3.0e-3F; }},
        {"surface far away", PAL_ERR_RANGE, true,
         [](pal_table& t) {
             for (std::uint32_t i = 0; i < PLANE; ++i) t.coef[i] = 0.5F;
         }},
        {"negative depth scale", PAL_ERR_RANGE, true, [](pal_table& t) { t.coef[2 * PLANE + 3] = -1.0F; }},
    };
}

}  // namespace

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
