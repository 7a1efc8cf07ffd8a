/// Whether a machine is fit for a loop at 1 kHz that pushes on a hand.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "host/latency/measure.hpp"

namespace palpate::latency {

/// Of the wake-ups' p99.9, ns. The figure is often quoted for libfranka; its present documentation does not
/// have it.
inline constexpr std::uint64_t SUITABLE_P99_9_NS = 300000;
/// Of the largest wake-up, ns: a later start is a missed period. libfranka's documentation: round trip and
/// the controller's own time together stay below 1 ms.
inline constexpr std::uint64_t WAKE_UP_MAX_NS = PERIOD_NS;
/// Of the ticks with a fresh sample: libfranka's communication_test warns below this.
inline constexpr double REPLY_SHARE_MIN = 0.95;
/// Fewer starts than this have no p99.9.
inline constexpr std::uint64_t N_STARTS_MIN = 1000;

enum class Suitability { SUITABLE, MARGINAL, NOT_SUITABLE, NOT_KNOWN };
[[nodiscard]] const char* word_of(Suitability suitability);

struct Verdict {
    Suitability suitability = Suitability::NOT_KNOWN;
    std::vector<std::string> reasons;  ///< sentences for a person; at least one
    /// Empty when the figures say something of this machine; else why not.
    std::string not_valid;
};

/// `stolen_s`: the hypervisor's share between begin and end of the run, in seconds of processor; nullopt: not
/// known.
[[nodiscard]] Verdict judge(const Measured& measured, std::optional<double> stolen_s);

}  // namespace palpate::latency
