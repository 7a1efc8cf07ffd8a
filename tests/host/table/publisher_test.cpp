#include "host/link/publisher.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "host/link/segment.hpp"

using namespace palpate;

namespace {

std::unique_ptr<pal_table> small_table(float spacing_m) {
    auto table = std::make_unique<pal_table>();
    table->n_nodes = 5;
    table->spacing_m = spacing_m;
    return table;
}

}  // namespace

TEST_CASE("tables are numbered in the order of publication, and the newest is taken") {
    const auto link = std::make_unique<pal_link>();
    pal_link_init(link.get(), 1);
    link::Publisher publisher(*link);
    CHECK(publisher.publish(small_table(1e-3F), 10).id == 1);
    CHECK(publisher.publish(small_table(2e-3F), 20).id == 2);
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
