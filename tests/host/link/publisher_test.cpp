#include "host/link/publisher.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "host/link/segment.hpp"
#include "tests/fuzz/good_table.hpp"

using namespace palpate;

namespace {

std::unique_ptr<pal_table> small_table(float spacing_m) {
    auto table = std::make_unique<pal_table>();
    fuzz::fill_good(*table, 5, 0);
    table->spacing_m = spacing_m;
    return table;
}

/// The last of the coefficients of a plane: 0 s, 1 K.
float& last_of(pal_table& table, std::size_t plane) {
    const std::size_t side = table.n_nodes + 2;
    return table.coef[(plane + 1) * side * side - 1];
}

}  // namespace

TEST_CASE("tables are numbered in the order of publication, and the newest is taken") {
    const auto link = std::make_unique<pal_link>();
    pal_link_init(link.get(), 1);
    link::Publisher publisher(*link);
    CHECK(publisher.publish(small_table(1e-3F), 10)->id == 1);
    CHECK(publisher.publish(small_table(2e-3F), 20)->id == 2);
    REQUIRE(pal_table_ring_take(&link->tables));
    CHECK(pal_table_ring_current(&link->tables)->id == 2);
    CHECK(pal_table_ring_current(&link->tables)->spacing_m == 2e-3F);
    CHECK_FALSE(pal_table_ring_take(&link->tables));
}

TEST_CASE("the last table is published again after 40 ticks, with a new number and the same content") {
    const auto link = std::make_unique<pal_link>();
    pal_link_init(link.get(), 1);
    link::Publisher publisher(*link);
    CHECK(publisher.refresh(100) == nullptr);  // nothing yet
    static_cast<void>(publisher.publish(small_table(1e-3F), 100));
    CHECK(publisher.refresh(139) == nullptr);
    const pal_table* again = publisher.refresh(140);
    REQUIRE(again != nullptr);
    CHECK(again->id == 2);
    CHECK(again->spacing_m == 1e-3F);
    CHECK(publisher.refresh(141) == nullptr);
}

TEST_CASE("a table that the loop would refuse is not sent, and is counted with its place and the reason") {
    const auto link = std::make_unique<pal_link>();
    pal_link_init(link.get(), 1);
    link::Publisher publisher(*link);
    REQUIRE(publisher.publish(small_table(1e-3F), 10));
    REQUIRE(pal_table_ring_take(&link->tables));
    const auto why = [&](const std::function<void(pal_table&)>& spoil) {
        auto table = small_table(1e-3F);
        table->made_for_m[1] = -0.002F;
        spoil(*table);
        CHECK(publisher.publish(std::move(table), 20) == nullptr);
        CHECK_FALSE(pal_table_ring_take(&link->tables));
        CHECK(publisher.refused().back().made_for_m[1] == -0.002F);
        return publisher.refused().back().why;
    };
    const std::string at = " at (0.0, -2.0, 0.0) mm";
    CHECK(why([](pal_table& t) { last_of(t, 1) = 6300.0F; }) ==
          "stiffness 6.3 kN/m" + at + " is above what the loop accepts (6.0 kN/m)");
    CHECK(why([](pal_table& t) { last_of(t, 1) = 4500.0F; }) ==
          "stiffness that changes by 4.0 kN/m in a mm" + at +
              " is steeper than the loop accepts (3.0 kN/m in a mm)");
    CHECK(why([](pal_table& t) { last_of(t, 0) = 0.00606F; }) ==
          "skin with a slope of 6.0" + at + " is steeper than the loop accepts (4.0)");
    CHECK(why([](pal_table& t) { t.axes[0] = 0.9F; }) == "a number outside what is safe" + at);
    CHECK(why([](pal_table& t) { last_of(t, 1) = NAN; }) ==
          "a broken table" + at + ": NaN or infinity where a number belongs");
    CHECK(publisher.refused().size() == 5);
    const pal_table* again = publisher.refresh(60);  // the good one stays the last
    REQUIRE(again != nullptr);
    CHECK(again->id == 2);
    CHECK(again->made_for_m[1] == 0.0F);
}

TEST_CASE(
    "the segment can be attached by its name while it lives, by its user only, and is gone afterwards") {
    std::string name;
    {
        const link::Segment segment;
        name = segment.name();
        const int fd = shm_open(name.c_str(), O_RDWR, 0);
        REQUIRE(fd >= 0);
        void* at = mmap(nullptr, sizeof(pal_link), PROT_READ, MAP_SHARED, fd, 0);
        REQUIRE(at != MAP_FAILED);
        CHECK(pal_link_check(static_cast<pal_link*>(at), sizeof(pal_link)) == PAL_OK);
        munmap(at, sizeof(pal_link));
        close(fd);
    }
    CHECK(shm_open(name.c_str(), O_RDWR, 0) < 0);
}
