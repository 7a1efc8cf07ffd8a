#include "host/link/publisher.hpp"

#include <cstring>

namespace palpate::link {

void Publisher::publish(pal_table& table) {
    table.id = ++last_id_;
    pal_table_seal(&table);
    std::memcpy(pal_table_ring_back(&link_->tables), &table, table.n_bytes);
    pal_table_ring_publish(&link_->tables);
}

}  // namespace palpate::link
