/// What a latency was measured on: the facts without which the figure means nothing.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace palpate::latency {

/// Empty, 0 or nullopt where the system does not say.
struct Machine {
    std::string cpu;  ///< model name
    unsigned n_cores = 0;
    std::string kernel;          ///< release, uname -r
    std::string kernel_version;  ///< uname -v
    std::string preemption;      ///< in words
    bool real_time_kernel = false;
    std::string governor;     ///< of the CPU frequency; several with commas
    std::string idle_driver;  ///< and its governor
    std::optional<double> load_1_min, load_5_min;
};

/// Reads below `root` (proc, sys): a test gives its own.
[[nodiscard]] Machine machine_facts(const std::filesystem::path& root = "/");
/// Whether the kernel is PREEMPT_RT; `version` is uname -v.
[[nodiscard]] bool is_real_time_kernel(const std::filesystem::path& root, const std::string& version);

/// One processor's frequency governor.
struct Governor {
    std::string cpu, name;
};
/// Of those that have one.
[[nodiscard]] std::vector<Governor> governors(const std::filesystem::path& root);

/// Time that a hypervisor gave to others while a processor of this machine wanted to run, s, all processors
/// together, since the start (/proc/stat, steps of 10 ms). nullopt when the system does not say.
[[nodiscard]] std::optional<double> stolen_s(const std::filesystem::path& root = "/");

/// A step of getting real time (PAL_REALTIME_*) and what came of it.
struct RealtimeStep {
    std::string what;
    enum class Outcome { GRANTED, REFUSED, NOT_ASKED } outcome;
};
[[nodiscard]] std::vector<RealtimeStep> realtime_steps(std::uint32_t granted, std::uint32_t refused);
[[nodiscard]] const char* word_of(RealtimeStep::Outcome outcome);

}  // namespace palpate::latency
