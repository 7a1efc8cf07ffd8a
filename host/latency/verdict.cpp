#include "host/latency/verdict.hpp"

#include "host/latency/words.hpp"

namespace palpate::latency {
namespace {

std::string us(std::uint64_t ns) {
    return us_text(static_cast<double>(ns)) + " us";
}

/// Everything that rules the machine out.
std::vector<std::string> obstacles(const Measured& measured) {
    std::vector<std::string> out;
    const Histogram& wake_up = measured.wake_up.histogram;
    if (measured.wake_up.known() && wake_up.max_ns() > WAKE_UP_MAX_NS) {
        out.push_back("the latest start was " + us(wake_up.max_ns()) + " late; 1000 us is a whole period");
    }
    if (measured.n_missed > 0) {
        out.push_back(std::to_string(measured.n_missed) + " periods went without a tick, up to " +
                      std::to_string(measured.longest_miss) + " in a row");
    }
    if (measured.reply_share && *measured.reply_share < REPLY_SHARE_MIN) {
        out.push_back("the device answered in time in " + share_text(*measured.reply_share) +
                      " of the ticks; 95 % are needed");
    }
    return out;
}

void judge_wake_up(const Quantity& wake_up, Verdict& verdict) {
    if (!wake_up.known()) {
        verdict.reasons.push_back("the wake-up is not known: " + wake_up.why_unknown);
        return;
    }
    const std::uint64_t n = wake_up.histogram.n();
    if (n < N_STARTS_MIN) {
        verdict.reasons.push_back("only " + std::to_string(n) + " starts: p99.9 needs 1000");
        return;
    }
    const std::uint64_t p99_9_ns = wake_up.histogram.percentile_ns(Level::P99_9);
    const bool fits = p99_9_ns <= SUITABLE_P99_9_NS;
    verdict.suitability = fits ? Suitability::SUITABLE : Suitability::MARGINAL;
    verdict.reasons.push_back("p99.9 of the wake-up is " + us(p99_9_ns) +
                              (fits ? ", within" : "; it should be within") + " 300 us");
}

}  // namespace

const char* word_of(Suitability suitability) {
    switch (suitability) {
        case Suitability::SUITABLE:
            return "suitable";
        case Suitability::MARGINAL:
            return "marginal";
        case Suitability::NOT_SUITABLE:
            return "not suitable";
        case Suitability::NOT_KNOWN:
            break;
    }
    return "not known";
}

Verdict judge(const Measured& measured, std::optional<double> stolen_s) {
    Verdict verdict;
    verdict.reasons = obstacles(measured);
    if (measured.n_ticks == 0) {
        verdict.reasons = {"no ticks"};
    } else if (measured.virtual_time) {
        verdict.reasons = {"virtual time says nothing of the machine"};
    } else if (!verdict.reasons.empty()) {
        verdict.suitability = Suitability::NOT_SUITABLE;
    } else {
        judge_wake_up(measured.wake_up, verdict);
        if (verdict.suitability == Suitability::SUITABLE) verdict.reasons.push_back("no period was missed");
    }
    if (!stolen_s) {
        verdict.not_valid = "not valid for latency: whether a hypervisor took time is not known";
    } else if (*stolen_s > 0.0) {
        verdict.not_valid = "not valid for latency: the hypervisor gave " + number_text(*stolen_s, 2) +
                            " s of the processors to others";
    }
    return verdict;
}

}  // namespace palpate::latency
