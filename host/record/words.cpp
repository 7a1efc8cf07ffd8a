#include <array>
#include <cinttypes>
#include <cstdio>

#include "host/record/record.hpp"

namespace palpate::record {
namespace {

constexpr const char* FAULTS[] = {"not-finite",    "workspace", "table-missing", "table-left",  "table-stale",
                                  "table-dropped", "table-bad", "force-clamp",   "motor-clamp", "late",
                                  "device-lost",   "e-stop",    "host-lost"};
static_assert(1U << (std::size(FAULTS) - 1) == PAL_FAULT_HOST_LOST);
constexpr const char* STATES[] = {"disabled", "homing", "ramp", "enabled", "paused", "fault"};
static_assert(std::size(STATES) - 1 == PAL_STATE_FAULT);

}  // namespace

std::string fault_words(std::uint32_t faults) {
    std::string out;
    for (std::uint32_t bit = 0; bit < 32; ++bit) {
        if ((faults >> bit & 1U) == 0) continue;
        if (!out.empty()) out += ' ';
        out += bit < std::size(FAULTS) ? FAULTS[bit] : "bit-" + std::to_string(bit);
    }
    return out.empty() ? "none" : out;
}

std::string utc_text(std::time_t unix_s) {
    std::tm parts{};
    gmtime_r(&unix_s, &parts);
    std::array<char, 32> text{};
    std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
    return text.data();
}

std::string hash_text(std::uint64_t hash) {
    std::array<char, 17> text{};
    std::snprintf(text.data(), text.size(), "%016" PRIx64, hash);
    return text.data();
}

std::string state_word(std::uint32_t state) {
    return state < std::size(STATES) ? STATES[state] : "state-" + std::to_string(state);
}

std::string stop_word(std::uint32_t stop) {
    return fault_words(stop);
}

}  // namespace palpate::record
