// A shared segment that another process filled with anything: the check reads no byte beyond it, and behind a
// header that passes the rings stay within their arrays whatever their words say.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "common/link.h"
#include "firmware/core/intake.h"

namespace {

void require(bool holds) {
    if (!holds) std::abort();
}

void check_bytes(const std::uint8_t* data, std::size_t size) {
    // A block of just this size, so that the address sanitizer sees a byte too far.
    void* const block = std::aligned_alloc(64, std::max<std::size_t>(size, 1));
    require(block != nullptr);
    std::memcpy(block, data, size);
    const pal_err err = pal_link_check(static_cast<const pal_link*>(block), size);
    require(err != PAL_OK || size >= sizeof(pal_link));
    std::free(block);
}

/// Words of a good segment overwritten: place (3 bytes) and value (4).
void check_rings(const std::uint8_t* data, std::size_t size) {
    static pal_link link;
    pal_link_init(&link, 1);
    for (; size >= 7; data += 7, size -= 7) {
        std::size_t place = data[0] | data[1] << 8 | data[2] << 16;
        if (place % 4 != 0)
            place = offsetof(pal_link, tables.state) + place % 8 * 64;  // the words that matter most
        std::memcpy(reinterpret_cast<std::uint8_t*>(&link) + place % (sizeof link - 4), data + 3, 4);
    }
    if (pal_link_check(&link, sizeof link) != PAL_OK) return;
    pal_state_reader reader{};
    pal_tick tick;
    for (int i = 0; i < 8; ++i) static_cast<void>(pal_state_ring_read(&link.ticks, &reader, &tick));
    static_cast<void>(pal_state_ring_waiting(&link.ticks, &reader));
    pal_intake intake{};
    intake.ring = &link.tables;
    intake.limits = pal_intake_limits_default();
    for (int i = 0; i < 4; ++i) {
        const pal_loop_tables* const tables = pal_intake_poll(&intake, i % 2 == 1);
        require(tables->now == nullptr || pal_table_header_ok(tables->now));
        static_cast<void>(pal_intake_check(&intake));
        pal_table_ring_publish(&link.tables);
    }
    pal_state_ring_push(&link.ticks, &tick);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    check_bytes(data, size);
    check_rings(data, size);
    return 0;
}
