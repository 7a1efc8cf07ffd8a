#include "host/link/publisher.hpp"

#include <cstring>
#include <utility>

namespace palpate::link {
namespace {

constexpr std::uint32_t REFRESH_TICKS =
    40;  // well within the 100 ticks after which the loop calls a table stale

}  // namespace

const pal_table& Publisher::publish(std::unique_ptr<pal_table> table, std::uint32_t now_tick) {
    last_ = std::move(table);
    last_tick_ = now_tick;
    last_->id = ++last_id_;
    pal_table_seal(last_.get());
    std::memcpy(pal_table_ring_back(&link_->tables), last_.get(), last_->n_bytes);
    pal_table_ring_publish(&link_->tables);
    return *last_;
}

const pal_table* Publisher::refresh(std::uint32_t now_tick) {
    if (!last_ || now_tick - last_tick_ < REFRESH_TICKS) return nullptr;
    return &publish(std::move(last_), now_tick);
}

}  // namespace palpate::link
