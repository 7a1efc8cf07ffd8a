#include "common/link.h"

#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <vector>

namespace {

std::unique_ptr<pal_link> make_link() {
    auto link = std::make_unique<pal_link>();
    pal_link_init(link.get(), 42);
    return link;
}

}  // namespace

TEST_CASE("a fresh link passes its check and holds nothing") {
    const auto link = make_link();
    CHECK(pal_link_check(link.get(), sizeof(pal_link)) == PAL_OK);
    CHECK(link->header.nonce == 42);
    CHECK_FALSE(pal_table_ring_take(&link->tables));
    pal_state_reader reader{};
    CHECK(pal_state_ring_waiting(&link->ticks, &reader) == 0);
}

TEST_CASE("a link of another layout is refused") {
    struct Broken {
        pal_err err;
        std::function<void(pal_link_header&)> breaking;
    };
    const std::vector<Broken> cases = {
        {PAL_ERR_MAGIC, [](pal_link_header& h) { h.magic = 0; }},
        {PAL_ERR_ENDIAN, [](pal_link_header& h) { h.magic = 0x4C494E4BU; }},
        {PAL_ERR_ENDIAN, [](pal_link_header& h) { h.endian = 0x04030201; }},
        {PAL_ERR_ABI, [](pal_link_header& h) { h.abi = PAL_LINK_ABI + 1; }},
        {PAL_ERR_SIZE, [](pal_link_header& h) { h.n_bytes -= 64; }},
        {PAL_ERR_SIZE, [](pal_link_header& h) { h.table_bytes += 4; }},
        {PAL_ERR_SIZE, [](pal_link_header& h) { h.tick_bytes = 128; }},
        {PAL_ERR_SIZE, [](pal_link_header& h) { h.n_slots = 3; }},
        {PAL_ERR_SIZE, [](pal_link_header& h) { h.n_ticks = 2048; }},
    };
    for (const Broken& broken : cases) {
        const auto link = make_link();
        broken.breaking(link->header);
        CHECK(pal_link_check(link.get(), sizeof(pal_link)) == broken.err);
    }
}

TEST_CASE("a truncated link is refused before its body is looked at") {
    const auto link = make_link();
    CHECK(pal_link_check(link.get(), sizeof(pal_link) - 1) == PAL_ERR_SIZE);
    CHECK(pal_link_check(link.get(), sizeof(pal_link_header) - 1) == PAL_ERR_SIZE);
    CHECK(pal_link_check(link.get(), 0) == PAL_ERR_SIZE);
}
