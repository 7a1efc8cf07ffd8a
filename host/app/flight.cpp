#include "host/app/flight.hpp"

#include <algorithm>
#include <utility>

namespace palpate::app {
namespace {

std::span<const pal_tick> last(std::span<const pal_tick> ticks) {
    return ticks.last(std::min(ticks.size(), FlightRecorder::TICKS));
}

/// The tables that these ticks name.
std::map<std::uint64_t, record::TableBytes> tables_of(
    std::span<const pal_tick> ticks, const std::map<std::uint64_t, record::TableBytes>& tables) {
    std::map<std::uint64_t, record::TableBytes> used;
    for (const pal_tick& tick : ticks) {
        for (const std::uint64_t id : {tick.table_id, tick.before_id}) {
            const auto found = tables.find(id);
            if (found != tables.end()) used.insert(*found);
        }
    }
    return used;
}

void write_flight(const std::filesystem::path& file, nlohmann::json header, const std::string& reason,
                  std::span<const pal_tick> ticks,
                  const std::map<std::uint64_t, record::TableBytes>& tables) {
    header["flight"] = {{"reason", reason}, {"last_tick", ticks.empty() ? 0U : ticks.back().tick}};
    record::write(file, {std::move(header), {ticks.begin(), ticks.end()}, tables_of(ticks, tables)});
}

}  // namespace

FlightRecorder::FlightRecorder(std::filesystem::path directory, nlohmann::json header)
    : directory_(std::move(directory)), header_(std::move(header)) {}

void FlightRecorder::look(std::span<const pal_tick> ticks,
                          const std::map<std::uint64_t, record::TableBytes>& tables) {
    for (; n_seen_ < ticks.size(); ++n_seen_) {
        const std::uint32_t stop = ticks[n_seen_].stop;
        if (stop != 0 && stop != stop_)
            note("stop: " + record::stop_word(stop), ticks.first(n_seen_ + 1), tables);
        stop_ = stop;
    }
}

void FlightRecorder::note(const std::string& reason, std::span<const pal_tick> ticks,
                          const std::map<std::uint64_t, record::TableBytes>& tables) {
    if (files_.size() >= FILES_MAX) return;
    const std::string name = "flight-" + std::to_string(files_.size() + 1) + ".palrec";
    write_flight(directory_ / name, header_, reason, last(ticks), tables);
    files_.push_back(name);
}

std::vector<pal_tick> last_ticks(const pal_link& link) {
    const std::uint32_t done = pal_link_load(&link.ticks.done);
    const auto n = std::min(done, static_cast<std::uint32_t>(FlightRecorder::TICKS));
    pal_state_reader reader{.next = done - n, .n_dropped = 0};
    std::vector<pal_tick> ticks;
    pal_tick tick{};
    while (ticks.size() < n && pal_state_ring_read(&link.ticks, &reader, &tick)) ticks.push_back(tick);
    return ticks;
}

std::string salvage_flight(const std::filesystem::path& directory, const nlohmann::json& header,
                           const std::string& name, const pal_link& link) {
    const std::vector<pal_tick> ticks = last_ticks(link);
    if (ticks.empty()) return "";
    const std::filesystem::path file = directory / ("orphan-" + name.substr(1) + ".palrec");
    write_flight(file, header, "its run was killed", ticks, {});
    return "a run that was killed left its last " + std::to_string(ticks.size()) +
           " ticks: " + file.filename().string();
}

}  // namespace palpate::app
