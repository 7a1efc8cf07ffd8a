/// The flight recorder: the last 2 s before each stop of a run in real time, in a file of its own that is
/// there at once, not only when the run has ended.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "common/link.h"
#include "host/record/record.hpp"

namespace palpate::app {

class FlightRecorder {
public:
    /// Files go to `directory` with `header` (palpate.record/1) and "flight": what stopped, and when.
    FlightRecorder(std::filesystem::path directory, nlohmann::json header);
    /// Sees all ticks of the run so far; for each newly latched stop writes flight-1.palrec, flight-2.palrec
    /// ... (FILES_MAX of them). Cost of a look: the new ticks only.
    void look(std::span<const pal_tick> ticks, const std::map<std::uint64_t, record::TableBytes>& tables);
    /// A stop that no tick can tell of: a process that died.
    void note(const std::string& reason, std::span<const pal_tick> ticks,
              const std::map<std::uint64_t, record::TableBytes>& tables);
    /// Names of the files so far.
    [[nodiscard]] const std::vector<std::string>& files() const { return files_; }

    static constexpr std::size_t TICKS = 2000;
    static constexpr std::size_t FILES_MAX = 20;

private:
    std::filesystem::path directory_;
    nlohmann::json header_;
    std::size_t n_seen_ = 0;
    std::uint32_t stop_ = 0;
    std::vector<std::string> files_;
};

/// The last 2 s that the loop wrote into a segment, oldest first.
[[nodiscard]] std::vector<pal_tick> last_ticks(const pal_link& link);

/// Writes what a killed run left in its segment as `directory`/orphan-NAME.palrec; nothing when it left no
/// tick. Returns words for a person; empty when there is nothing to say.
[[nodiscard]] std::string salvage_flight(const std::filesystem::path& directory, const nlohmann::json& header,
                                         const std::string& name, const pal_link& link);

}  // namespace palpate::app
