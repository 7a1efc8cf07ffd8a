/// Puts finished tables into the ring, numbered in the order of publication.
#pragma once
#include <cstdint>
#include <memory>

#include "common/link.h"

namespace palpate::link {

class Publisher {
public:
    /// The only writer of `link`'s table ring.
    explicit Publisher(pal_link& link) : link_(&link) {}
    /// Numbers and seals `table` and makes a copy of it the newest. Returns what was published. About 10 us.
    const pal_table& publish(std::unique_ptr<pal_table> table, std::uint32_t now_tick);
    /// The last table again, with a new number, when it was published 40 ticks ago or more: so the loop knows
    /// that the host lives however long the next one takes. nullptr when there is none or it is young enough.
    const pal_table* refresh(std::uint32_t now_tick);

private:
    pal_link* link_;
    std::unique_ptr<pal_table> last_;
    std::uint64_t last_id_ = 0;
    std::uint32_t last_tick_ = 0;
};

}  // namespace palpate::link
