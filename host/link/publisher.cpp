#include "host/link/publisher.hpp"

#include <cstring>
#include <utility>

#include "host/link/refusal.hpp"

namespace palpate::link {

const pal_table* Publisher::publish(std::unique_ptr<pal_table> table, std::uint32_t now_tick) {
    table->id = last_id_ + 1;
    pal_table_seal(table.get());
    if (auto why = refusal_of(*table)) {
        const float* at_m = table->made_for_m;
        refused_.push_back({{at_m[0], at_m[1], at_m[2]}, std::move(*why)});
        return nullptr;
    }
    pal_table* back = pal_table_ring_back(&link_->tables);
    if (back != nullptr) std::memcpy(back, table.get(), table->n_bytes);
    if (back == nullptr || !pal_table_ring_publish(&link_->tables)) {
        const float* at_m = table->made_for_m;
        refused_.push_back({{at_m[0], at_m[1], at_m[2]},
                            "the segment's table ring is damaged; no table can be handed over any more"});
        return nullptr;
    }
    last_ = std::move(table);
    last_id_ = last_->id;
    last_tick_ = now_tick;
    return last_.get();
}

const pal_table* Publisher::refresh(std::uint32_t now_tick) {
    if (!last_ || now_tick - last_tick_ < REFRESH_TICKS) return nullptr;
    return publish(std::move(last_), now_tick);
}

}  // namespace palpate::link
