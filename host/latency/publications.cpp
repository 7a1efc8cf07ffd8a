#include "host/latency/publications.hpp"

#include <cstring>

#include "common/table.h"

namespace palpate::latency {
namespace {

[[noreturn]] void refuse() {
    throw record::Error("published_ns of the record's header is not an array of [table, ns]");
}

}  // namespace

Publications publications_of(const record::Record& record) {
    Publications out;
    for (const auto& [id, bytes] : record.tables) {
        if (bytes.size() < offsetof(pal_table, tick) + sizeof(pal_table::tick)) continue;
        std::uint32_t tick = 0;
        std::memcpy(&tick, bytes.data() + offsetof(pal_table, tick), sizeof tick);
        out[id].made_for_tick = tick;
    }
    const auto published = record.header.find("published_ns");
    if (published == record.header.end()) return out;
    if (!published->is_array()) refuse();
    const auto is_count = [](const nlohmann::json& value) {
        return value.is_number_integer() && (value.is_number_unsigned() || value.get<std::int64_t>() >= 0);
    };
    for (const nlohmann::json& pair : *published) {
        if (!pair.is_array() || pair.size() != 2 || !is_count(pair[0]) || !is_count(pair[1])) refuse();
        out[pair[0].get<std::uint64_t>()].t_ns = pair[1].get<std::uint64_t>();
    }
    return out;
}

}  // namespace palpate::latency
