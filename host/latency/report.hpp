/// What was measured, on what, and what it means: for a person, for a program, as a picture.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "host/latency/machine.hpp"
#include "host/latency/measure.hpp"
#include "host/latency/verdict.hpp"

namespace palpate::latency {

struct Report {
    Machine machine;                 ///< when the run began
    std::optional<double> stolen_s;  ///< during the run; nullopt: not known
    std::optional<LoopWords> loop;   ///< nullopt: a record does not hold them
    Measured measured;
    Verdict verdict;
};

/// Judges, and puts together.
[[nodiscard]] Report make_report(Machine machine, std::optional<double> stolen_s,
                                 std::optional<LoopWords> loop, Measured measured);

/// A table in us with the machine, the verdict and its reasons; lines of 110 characters or so.
[[nodiscard]] std::string text_of(const Report& report);

/// Schema palpate.latency/1. Each quantity is a key of the document (quantity_names()): known, what, n,
/// n_unknown, and min_us, mean_us, p50_us, p90_us, p99_us, p99_9_us, p99_99_us, max_us, histogram ([from_ns,
/// to_ns, n] for each bin with samples; to_ns null: no end), or why_unknown instead.
[[nodiscard]] nlohmann::json json_of(const Report& report);

/// As cyclictest -h 2000 -q prints it: a line "us count" for each us below 2000 of one thread, then the
/// comments with total, min, avg, max and overflows.
[[nodiscard]] std::string cyclictest_text(const Histogram& histogram);

/// Wake-up, tick cost and sensor-to-force: how many lay where (log scale), and which share was above a value.
/// Words for a person when there is no picture and why; empty when there is one.
[[nodiscard]] std::string draw_histograms(const std::filesystem::path& png, const Report& report,
                                          const std::string& title);

}  // namespace palpate::latency
