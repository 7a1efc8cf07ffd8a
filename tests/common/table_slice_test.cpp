// The check of a table in slices: the same answer as the whole, and no more memory looked at than it says.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <string>

#include "tests/common/broken_tables.hpp"
#include "tests/common/tables.hpp"

namespace {

using tables::Broken;
using tables::broken_tables;

struct Sliced {
    pal_err err = PAL_OK;
    std::uint32_t n_slices = 0;
};

Sliced in_slices(const pal_table& table, std::uint32_t n_words_max) {
    const auto limits = tables::limits();
    pal_table_checking checking{};
    Sliced result;
    bool ended = false;
    while (!ended) {
        result.n_slices += 1;
        ended = pal_table_check_slice(&checking, &table, &limits, n_words_max, &result.err);
        if (!ended) REQUIRE(result.err == PAL_OK);
    }
    const pal_table_checking zero{};
    CHECK(std::memcmp(&checking, &zero, sizeof zero) == 0);
    return result;
}

std::uint32_t n_coefs(std::uint32_t n_nodes) {
    return 3 * (n_nodes + 2) * (n_nodes + 2);
}

/// The header is in each slice; its words behind the CRC are in the first pass.
std::uint32_t n_words(std::uint32_t n_nodes) {
    return 3 * n_coefs(n_nodes) + 35;
}

/// Whole pages for one table, of which some may be shut.
class Pages {
public:
    explicit Pages(std::size_t n_bytes)
        : n_page_(static_cast<std::size_t>(sysconf(_SC_PAGESIZE))),
          n_bytes_((n_bytes + n_page_ - 1) / n_page_ * n_page_),
          at_(static_cast<char*>(mmap(nullptr, n_bytes_ + n_page_, PROT_READ | PROT_WRITE,
                                      MAP_PRIVATE | MAP_ANONYMOUS, -1, 0))) {
        REQUIRE(at_ != MAP_FAILED);
        REQUIRE(mprotect(at_ + n_bytes_, n_page_, PROT_NONE) == 0);
    }
    Pages(const Pages&) = delete;
    Pages& operator=(const Pages&) = delete;
    ~Pages() { munmap(at_, n_bytes_ + n_page_); }

    char* begin() { return at_; }
    char* end() { return at_ + n_bytes_; }  ///< a shut page begins here
    /// Opens those that [from, to) touches, and the first, which holds the header; shuts all others.
    void open_only(std::size_t from, std::size_t to) {
        for (std::size_t page = 0; page < n_bytes_; page += n_page_) {
            const bool open = page == 0 || (page < to && from < page + n_page_);
            if (mprotect(at_ + page, n_page_, open ? PROT_READ : PROT_NONE) != 0) FAIL("mprotect");
        }
    }

private:
    std::size_t n_page_, n_bytes_;
    char* at_;
};

struct Window {
    std::size_t from = SIZE_MAX, to = 0;
    void add(std::size_t a, std::size_t b) {
        from = std::min(from, a);
        to = std::max(to, b);
    }
};

/// The bytes that words [first, last) of the three passes stand for; the third looks one row back as well.
Window bytes_of(std::uint32_t n_nodes, std::size_t first, std::size_t last) {
    const std::size_t c = n_coefs(n_nodes), row = n_nodes + 2;
    constexpr std::size_t COEF = offsetof(pal_table, coef) / 4;
    Window words;
    const auto pass = [&](std::size_t begin, std::size_t end, std::size_t table_word, std::size_t back) {
        const std::size_t a = std::max(first, begin), b = std::min(last, end);
        const std::size_t from = a - begin + table_word;
        if (a < b) words.add(from - std::min(from, back), b - begin + table_word);
    };
    pass(0, c + 35, 4, 0);
    pass(c + 35, 2 * c + 35, COEF, 0);
    pass(2 * c + 35, 3 * c + 35, COEF, row);
    return {4 * words.from, 4 * words.to};
}

}  // namespace

TEST_CASE("in slices of any size each broken table is refused for the reason that the whole check gives") {
    const auto n_words_max = GENERATE(as<std::uint32_t>{}, 1, 7, 64, 1000, 4096, 1000000, 0xFFFFFFFFU);
    for (const Broken& broken : broken_tables()) {
        INFO(broken.how << " in slices of " << n_words_max);
        const auto table = tables::make();
        broken.breaking(*table);
        if (broken.sealed) pal_table_seal(table.get());
        CHECK(in_slices(*table, n_words_max).err == broken.err);
    }
}

TEST_CASE("each pair of neighbours that differ by too much is seen, whole and cut between the two") {
    const auto n_words_max = GENERATE(as<std::uint32_t>{}, 1, 7, 0xFFFFFFFFU);
    const bool along_u = GENERATE(as<bool>{}, true, false);
    const bool of_s = GENERATE(as<bool>{}, true, false);
    const std::uint32_t side = 7, back = along_u ? side : 1;
    const float spacing_m = 1.0e-3F;
    const float most = (of_s ? 4.0F : 3.0e6F) * spacing_m;  // 4 mm, 3000 N/m
    const float middle = of_s ? 0.0F : 3000.0F;
    const auto put = [&](pal_table& table, std::uint32_t at, float share) {
        const std::uint32_t plane = of_s ? 0 : side * side;
        table.coef[plane + at] = middle + share * most;
    };
    for (std::uint32_t at = back; at < side * side; ++at) {
        if (!along_u && at % side == 0) continue;
        INFO("coefficient " << at << " in slices of " << n_words_max);
        // Either alone is within reach of all its neighbours; the two are not of each other.
        const auto table = tables::make({}, 5);
        table->spacing_m = spacing_m;
        table->valid_radius_m = 2.0F * spacing_m;
        for (std::uint32_t i = 0; i < side * side; ++i) put(*table, i, 0.0F);
        put(*table, at, 0.45F);
        put(*table, at - back, -0.45F);
        pal_table_seal(table.get());
        CHECK(in_slices(*table, n_words_max).err == PAL_OK);
        put(*table, at, 0.55F);
        put(*table, at - back, -0.55F);
        pal_table_seal(table.get());
        CHECK(in_slices(*table, n_words_max).err == PAL_ERR_RANGE);
    }
}

TEST_CASE("NaN in any coefficient is told as such in slices, whatever else is wrong before it") {
    const auto n_words_max = GENERATE(as<std::uint32_t>{}, 1, 7, 64, 1000);
    for (std::uint32_t i = 0; i < 3 * 49; ++i) {
        const auto table = tables::make({}, 5);
        table->coef[i == 0 ? 1 : 0] = 1.0e6F;
        table->spacing_m = -1.0F;
        table->coef[i] = std::numeric_limits<float>::quiet_NaN();
        pal_table_seal(table.get());
        INFO("coefficient " << i);
        CHECK(in_slices(*table, n_words_max).err == PAL_ERR_NOT_FINITE);
    }
}

TEST_CASE("of two things that are wrong the one that is checked first is told, whole and in slices") {
    // Magic and byte order are one word; an id and a law are told before the numbers.
    const auto rank = [](const Broken& broken) {
        const std::string how = broken.how;
        if (how == "id" || how == "law") return 5;
        switch (broken.err) {
            case PAL_ERR_ENDIAN:
            case PAL_ERR_MAGIC:
                return 1;
            case PAL_ERR_ABI:
                return 2;
            case PAL_ERR_SIZE:
                return 3;
            case PAL_ERR_CRC:
                return 4;
            case PAL_ERR_NOT_FINITE:
                return 6;
            default:
                return 7;
        }
    };
    const auto limits = tables::limits();
    const auto all = broken_tables();
    int n_pairs = 0;
    for (const Broken& first : all) {
        for (const Broken& later : all) {
            if (rank(first) >= rank(later)) continue;
            const auto table = tables::make();
            // Those that leave it unsealed come last, for sealing mends them; else `first`, which may take
            // the other's place.
            if (later.sealed) later.breaking(*table);
            if (first.sealed) first.breaking(*table);
            if (later.sealed || first.sealed) pal_table_seal(table.get());
            if (!later.sealed) later.breaking(*table);
            if (!first.sealed) first.breaking(*table);
            INFO(first.how << " and " << later.how);
            CHECK(pal_table_check(table.get(), &limits) == first.err);
            CHECK(in_slices(*table, 1000).err == first.err);
            ++n_pairs;
        }
    }
    CHECK(n_pairs > 300);
}

TEST_CASE("a good table passes in slices, and takes as many as its words say") {
    const auto n_words_max = GENERATE(as<std::uint32_t>{}, 1, 7, 64, 1000, 4096);
    for (std::uint32_t n_nodes = 5; n_nodes <= 65; n_nodes += 2) {
        INFO(n_nodes << " nodes in slices of " << n_words_max);
        const auto table = tables::make({}, n_nodes);
        const Sliced sliced = in_slices(*table, n_words_max);
        CHECK(sliced.err == PAL_OK);
        CHECK(sliced.n_slices == (n_words(n_nodes) + n_words_max - 1) / n_words_max);
    }
}

TEST_CASE("a slice of no words still goes on") {
    CHECK(in_slices(*tables::make({}, 5), 0).n_slices == n_words(5));
}

TEST_CASE("a slice touches no page but the header's and those of its own words") {
    const auto n_words_max = GENERATE(as<std::uint32_t>{}, 97, 512, 1000, 4096);
    const std::uint32_t n_nodes = 65;
    Pages pages(sizeof(pal_table));
    std::memcpy(pages.begin(), tables::make({}, n_nodes).get(), sizeof(pal_table));
    const auto* table = reinterpret_cast<const pal_table*>(pages.begin());
    const auto limits = tables::limits();
    pal_table_checking checking{};
    pal_err err = PAL_OK;
    bool ended = false;
    std::size_t first = 0;
    for (; !ended; first += n_words_max) {
        // A look beyond them is a fault of the processor, and with it of this test.
        const Window bytes = bytes_of(n_nodes, first, first + n_words_max);
        pages.open_only(bytes.from, bytes.to);
        ended = pal_table_check_slice(&checking, table, &limits, n_words_max, &err);
    }
    CHECK(err == PAL_OK);
    CHECK(first >= n_words(n_nodes));
}

TEST_CASE("a size that is rewritten between two slices leads none beyond the table") {
    const auto rewritten = GENERATE(as<std::uint32_t>{}, 7, 65, 0x80000001U, 0xFFFFFFFFU);
    const std::uint32_t n_bytes = pal_table_bytes(5);
    const auto good = tables::make({}, 5);
    const auto limits = tables::limits();
    Pages pages(n_bytes);
    auto* table = reinterpret_cast<pal_table*>(pages.end() - n_bytes);  // the page behind it is shut
    for (std::uint32_t at = 1; at < (n_words(5) + 6) / 7; ++at) {
        std::memcpy(static_cast<void*>(table), good.get(), n_bytes);
        pal_table_checking checking{};
        pal_err err = PAL_OK;
        bool ended = false;
        for (std::uint32_t n = 0; !ended; ++n) {
            if (n == at) {
                table->n_nodes = rewritten;
                table->n_bytes = pal_table_bytes(rewritten);
            }
            REQUIRE(n < (n_words(5) + 6) / 7);
            ended = pal_table_check_slice(&checking, table, &limits, 7, &err);
        }
        // n_nodes is word 10, in the first slice of the CRC; what follows goes by what was read then.
        CHECK(err == PAL_OK);
    }
}
