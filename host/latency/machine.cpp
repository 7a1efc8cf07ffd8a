#include "host/latency/machine.hpp"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "common/link.h"
#include "host/record/record.hpp"

namespace palpate::latency {
namespace {

namespace fs = std::filesystem;

/// Model and number of processors.
void look_at_cpus(const fs::path& root, Machine& machine) {
    std::ifstream in(root / "proc/cpuinfo");
    for (std::string line; std::getline(in, line);) {
        const std::size_t colon = line.find(": ");
        if (line.rfind("processor", 0) == 0) ++machine.n_cores;
        if (line.rfind("model name", 0) == 0 && colon != std::string::npos)
            machine.cpu = line.substr(colon + 2);
    }
}

/// The bracketed word of "none (voluntary) full", which only root can read.
std::string mode_in_debug(const fs::path& root) {
    const std::string text = record::text_in(root / "sys/kernel/debug/sched/preempt");
    const std::size_t from = text.find('('), to = text.find(')');
    return from == std::string::npos || to == std::string::npos || to < from
               ? ""
               : text.substr(from + 1, to - from - 1);
}

/// What preempt= on the kernel's command line says.
std::string mode_asked(const fs::path& root) {
    std::istringstream words(record::text_in(root / "proc/cmdline"));
    const std::string key = "preempt=";
    for (std::string word; words >> word;) {
        if (word.rfind(key, 0) == 0) return word.substr(key.size());
    }
    return "";
}

std::string preemption_words(const fs::path& root, const std::string& version) {
    if (is_real_time_kernel(root, version)) return "PREEMPT_RT";
    if (version.find("PREEMPT_DYNAMIC") != std::string::npos) {
        if (const std::string mode = mode_in_debug(root); !mode.empty()) return "PREEMPT_DYNAMIC, " + mode;
        if (const std::string mode = mode_asked(root); !mode.empty()) {
            return "PREEMPT_DYNAMIC, " + mode + " (command line)";
        }
        return "PREEMPT_DYNAMIC, mode not readable";
    }
    if (version.find("PREEMPT") != std::string::npos) return "PREEMPT";
    return version.empty() ? "" : "none or voluntary";
}

std::string governor_words(const fs::path& root) {
    std::vector<std::string> names;
    for (const Governor& governor : governors(root)) {
        if (std::find(names.begin(), names.end(), governor.name) == names.end())
            names.push_back(governor.name);
    }
    std::string words;
    for (const std::string& name : names) words += (words.empty() ? "" : ", ") + name;
    return words;
}

std::string idle_words(const fs::path& root) {
    const fs::path idle = root / "sys/devices/system/cpu/cpuidle";
    const std::string driver = record::text_in(idle / "current_driver");
    std::string governor = record::text_in(idle / "current_governor");
    if (governor.empty()) governor = record::text_in(idle / "current_governor_ro");
    return driver.empty() || governor.empty() ? driver : driver + ", governor " + governor;
}

}  // namespace

bool is_real_time_kernel(const fs::path& root, const std::string& version) {
    return record::text_in(root / "sys/kernel/realtime") == "1" ||
           version.find("PREEMPT_RT") != std::string::npos;
}

std::vector<Governor> governors(const fs::path& root) {
    std::vector<Governor> found;
    std::error_code none;
    for (const auto& cpu : fs::directory_iterator(root / "sys/devices/system/cpu", none)) {
        const std::string name = record::text_in(cpu.path() / "cpufreq/scaling_governor");
        if (!name.empty()) found.push_back({cpu.path().filename().string(), name});
    }
    std::sort(found.begin(), found.end(), [](const Governor& a, const Governor& b) { return a.cpu < b.cpu; });
    return found;
}

Machine machine_facts(const fs::path& root) {
    Machine machine;
    look_at_cpus(root, machine);
    machine.kernel = record::text_in(root / "proc/sys/kernel/osrelease");
    machine.kernel_version = record::text_in(root / "proc/sys/kernel/version");
    machine.real_time_kernel = is_real_time_kernel(root, machine.kernel_version);
    machine.preemption = preemption_words(root, machine.kernel_version);
    machine.governor = governor_words(root);
    machine.idle_driver = idle_words(root);
    std::ifstream loads(root / "proc/loadavg");
    double load = 0.0;
    if (loads >> load) machine.load_1_min = load;
    if (loads >> load) machine.load_5_min = load;
    return machine;
}

std::optional<double> stolen_s(const fs::path& root) {
    std::ifstream in(root / "proc/stat");
    std::string name;
    std::uint64_t ticks = 0;
    if (!(in >> name) || name != "cpu") return std::nullopt;
    // cpu user nice system idle iowait irq softirq steal ...: proc(5)
    for (int i = 0; i < 8; ++i) {
        if (!(in >> ticks)) return std::nullopt;
    }
    const long per_s = sysconf(_SC_CLK_TCK);
    if (per_s <= 0) return std::nullopt;
    return static_cast<double>(ticks) / static_cast<double>(per_s);
}

std::vector<RealtimeStep> realtime_steps(std::uint32_t granted, std::uint32_t refused) {
    constexpr struct {
        pal_realtime bit;
        const char* what;
    } STEPS[] = {{PAL_REALTIME_MEMORY_LOCKED, "locked memory"},
                 {PAL_REALTIME_STACK_TOUCHED, "touched stack"},
                 {PAL_REALTIME_TIMER_SLACK, "timer slack of 1 ns"},
                 {PAL_REALTIME_CPU, "one processor"},
                 {PAL_REALTIME_CPU_LATENCY, "no deep sleep of the processors"},
                 {PAL_REALTIME_FIFO, "SCHED_FIFO"},
                 {PAL_REALTIME_DEADLINE, "SCHED_DEADLINE"}};
    std::vector<RealtimeStep> out;
    for (const auto& step : STEPS) {
        using Outcome = RealtimeStep::Outcome;
        const auto bit = static_cast<std::uint32_t>(step.bit);
        out.push_back({step.what, (refused & bit) != 0   ? Outcome::REFUSED
                                  : (granted & bit) != 0 ? Outcome::GRANTED
                                                         : Outcome::NOT_ASKED});
    }
    return out;
}

const char* word_of(RealtimeStep::Outcome outcome) {
    switch (outcome) {
        case RealtimeStep::Outcome::GRANTED:
            return "granted";
        case RealtimeStep::Outcome::REFUSED:
            return "refused";
        case RealtimeStep::Outcome::NOT_ASKED:
            break;
    }
    return "not asked for";
}

}  // namespace palpate::latency
