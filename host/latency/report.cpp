#include "host/latency/report.hpp"

#include <array>
#include <cinttypes>
#include <cstdio>
#include <limits>
#include <utility>

#include "host/latency/words.hpp"

namespace palpate::latency {
namespace {

using Json = nlohmann::json;

constexpr struct {
    Level level;
    const char* key;
    const char* word;
} LEVELS[] = {{Level::P50, "p50_us", "p50"},
              {Level::P90, "p90_us", "p90"},
              {Level::P99, "p99_us", "p99"},
              {Level::P99_9, "p99_9_us", "p99.9"},
              {Level::P99_99, "p99_99_us", "p99.99"}};

double us_of(std::uint64_t ns) {
    return static_cast<double>(ns) / 1000.0;
}

std::string padded(const std::string& text, int width) {
    std::array<char, 160> out{};
    std::snprintf(out.data(), out.size(), "%*s", width, text.c_str());
    return out.data();
}

std::string or_unknown(const std::string& text) {
    return text.empty() ? "not known" : text;
}

std::string line(const std::string& what, const std::string& words) {
    return padded(what, -18) + words + '\n';
}

std::string quantity_line(const QuantityName& name, const Quantity& quantity) {
    std::string out = padded(name.key, -18);
    if (!quantity.known()) return out + "not known: " + quantity.why_unknown + '\n';
    const Histogram& histogram = quantity.histogram;
    out += padded(std::to_string(histogram.n()), 9);
    out += padded(us_text(static_cast<double>(histogram.min_ns())), 9);
    out += padded(us_text(histogram.mean_ns()), 9);
    for (const auto& level : LEVELS) {
        out += padded(us_text(static_cast<double>(histogram.percentile_ns(level.level))), 9);
    }
    return out + padded(us_text(static_cast<double>(histogram.max_ns())), 9) + '\n';
}

std::string table_text(const Measured& measured) {
    std::string out = padded("us", -18) + padded("n", 9) + padded("min", 9) + padded("mean", 9);
    for (const auto& level : LEVELS) out += padded(level.word, 9);
    out += padded("max", 9) + '\n';
    for (const QuantityName& name : quantity_names()) out += quantity_line(name, measured.*name.member);
    return out;
}

std::string run_text(const Measured& measured) {
    std::string out =
        line("run", std::to_string(measured.n_ticks) + " ticks in " + number_text(measured.duration_s, 3) +
                        " s" + (measured.virtual_time ? ", virtual time" : ""));
    std::string missed = std::to_string(measured.n_missed) + ", " + std::to_string(measured.longest_miss) +
                         " in a row at most";
    if (measured.n_missed_not_late > 0) {
        missed += ", " + std::to_string(measured.n_missed_not_late) + " not explained by a late start";
    }
    out += line("missed periods", missed);
    std::string replies =
        measured.reply_share ? share_text(*measured.reply_share) + " of the ticks" : "not known: no ticks";
    if (measured.reply_share_min)
        replies += ", " + share_text(*measured.reply_share_min) + " of the worst 100 in a row";
    out += line("replies in time", replies);
    const std::uint64_t lost = measured.n_lost_records + measured.n_bad_records;
    if (lost > 0) out += line("records", std::to_string(lost) + " lost or out of order: not in the figures");
    return out;
}

std::string loop_text(const std::optional<LoopWords>& loop) {
    if (!loop) return line("real time", "not known: the loop's words were not read");
    std::string out;
    using Outcome = RealtimeStep::Outcome;
    for (const Outcome outcome : {Outcome::GRANTED, Outcome::REFUSED, Outcome::NOT_ASKED}) {
        std::string steps;
        for (const RealtimeStep& step : realtime_steps(loop->granted, loop->refused)) {
            if (step.outcome == outcome) steps += (steps.empty() ? "" : ", ") + step.what;
        }
        if (!steps.empty()) out += line(word_of(outcome), steps);
    }
    return out + line("disturbances", std::to_string(loop->n_minor_faults) + " page faults (" +
                                          std::to_string(loop->n_major_faults) + " from disk), " +
                                          std::to_string(loop->n_preempted) + " preemptions");
}

std::string machine_text(const Machine& machine, std::optional<double> stolen_s) {
    const auto load = [](std::optional<double> value) {
        return value ? number_text(*value, 2) : "not known";
    };
    return line("machine", or_unknown(machine.cpu) + ", " + std::to_string(machine.n_cores) + " processors") +
           line("kernel", or_unknown(machine.kernel) + ", preemption " + or_unknown(machine.preemption)) +
           line("power", "governor " + or_unknown(machine.governor) + ", idle driver " +
                             or_unknown(machine.idle_driver)) +
           line("load", load(machine.load_1_min) + " in 1 min, " + load(machine.load_5_min) + " in 5 min") +
           line("stolen", stolen_s ? number_text(*stolen_s, 2) + " s by the hypervisor" : "not known");
}

Json or_null(const std::string& text) {
    return text.empty() ? Json(nullptr) : Json(text);
}

Json or_null(std::optional<double> value) {
    return value ? Json(*value) : Json(nullptr);
}

Json quantity_json(const QuantityName& name, const Quantity& quantity) {
    const Histogram& histogram = quantity.histogram;
    Json out = {{"what", name.words},
                {"known", quantity.known()},
                {"n", histogram.n()},
                {"n_unknown", quantity.n_unknown}};
    if (!quantity.known()) {
        out["why_unknown"] = quantity.why_unknown;
        return out;
    }
    out["min_us"] = us_of(histogram.min_ns());
    out["mean_us"] = histogram.mean_ns() / 1000.0;
    for (const auto& level : LEVELS) out[level.key] = us_of(histogram.percentile_ns(level.level));
    out["max_us"] = us_of(histogram.max_ns());
    Json bins = Json::array();
    for (const Histogram::Bin& bin : histogram.bins()) {
        const bool ends = bin.to_ns != std::numeric_limits<std::uint64_t>::max();
        bins.push_back({bin.from_ns, ends ? Json(bin.to_ns) : Json(nullptr), bin.n});
    }
    out["histogram"] = bins;
    return out;
}

Json loop_json(const LoopWords& loop) {
    Json steps = Json::array();
    for (const RealtimeStep& step : realtime_steps(loop.granted, loop.refused)) {
        steps.push_back({{"what", step.what}, {"outcome", word_of(step.outcome)}});
    }
    return {{"realtime", steps},
            {"n_minor_faults", loop.n_minor_faults},
            {"n_major_faults", loop.n_major_faults},
            {"n_preempted", loop.n_preempted}};
}

Json machine_json(const Machine& machine) {
    return {{"cpu", or_null(machine.cpu)},
            {"n_cores", machine.n_cores},
            {"kernel", or_null(machine.kernel)},
            {"kernel_version", or_null(machine.kernel_version)},
            {"preemption", or_null(machine.preemption)},
            {"real_time_kernel", machine.real_time_kernel},
            {"governor", or_null(machine.governor)},
            {"idle_driver", or_null(machine.idle_driver)},
            {"load_1_min", or_null(machine.load_1_min)},
            {"load_5_min", or_null(machine.load_5_min)}};
}

}  // namespace

Report make_report(Machine machine, std::optional<double> stolen_s, std::optional<LoopWords> loop,
                   Measured measured) {
    Verdict verdict = judge(measured, stolen_s);
    return {std::move(machine), stolen_s, loop, std::move(measured), std::move(verdict)};
}

std::string text_of(const Report& report) {
    std::string out = machine_text(report.machine, report.stolen_s) + loop_text(report.loop) +
                      run_text(report.measured) + '\n' + table_text(report.measured) + '\n' +
                      line("verdict", word_of(report.verdict.suitability));
    for (const std::string& reason : report.verdict.reasons) out += line("", reason);
    if (!report.verdict.not_valid.empty()) out += line("", report.verdict.not_valid);
    return out;
}

Json json_of(const Report& report) {
    const Measured& measured = report.measured;
    Json out = {{"schema", "palpate.latency/1"},
                {"verdict",
                 {{"suitability", word_of(report.verdict.suitability)},
                  {"reasons", report.verdict.reasons},
                  {"valid_for_latency", report.verdict.not_valid.empty()},
                  {"why_not_valid", or_null(report.verdict.not_valid)}}},
                {"machine", machine_json(report.machine)},
                {"stolen_s", or_null(report.stolen_s)},
                {"loop", report.loop ? loop_json(*report.loop) : Json(nullptr)},
                {"run",
                 {{"n_ticks", measured.n_ticks},
                  {"duration_s", measured.duration_s},
                  {"virtual_time", measured.virtual_time},
                  {"n_missed", measured.n_missed},
                  {"longest_miss", measured.longest_miss},
                  {"n_missed_not_late", measured.n_missed_not_late},
                  {"n_lost_records", measured.n_lost_records},
                  {"n_bad_records", measured.n_bad_records}}},
                {"replies",
                 {{"n", measured.n_replies},
                  {"share", or_null(measured.reply_share)},
                  {"share_min_of_100", or_null(measured.reply_share_min)}}}};
    for (const QuantityName& name : quantity_names()) {
        out[name.key] = quantity_json(name, measured.*name.member);
    }
    return out;
}

std::string cyclictest_text(const Histogram& histogram) {
    constexpr std::uint64_t US_NS = 1000, N_LINES = 2000;
    std::array<std::uint64_t, N_LINES> counts{};
    std::uint64_t n_over = 0;
    for (const Histogram::Bin& bin : histogram.bins()) {
        (bin.from_ns / US_NS < N_LINES ? counts[bin.from_ns / US_NS] : n_over) += bin.n;
    }
    std::string out = "# Histogram\n";
    std::array<char, 64> text{};
    for (std::size_t us = 0; us < N_LINES; ++us) {
        std::snprintf(text.data(), text.size(), "%06zu %06" PRIu64 "\n", us, counts[us]);
        out += text.data();
    }
    const auto comment = [&](const char* what, std::uint64_t value, int width) {
        std::snprintf(text.data(), text.size(), "# %s: %0*" PRIu64 "\n", what, width, value);
        out += text.data();
    };
    comment("Total", histogram.n() - n_over, 9);
    comment("Min Latencies", histogram.min_ns() / US_NS, 5);
    comment("Avg Latencies", static_cast<std::uint64_t>(histogram.mean_ns()) / US_NS, 5);
    comment("Max Latencies", histogram.max_ns() / US_NS, 5);
    comment("Histogram Overflows", n_over, 5);
    return out;
}

}  // namespace palpate::latency
