/// Is this machine ready for a Falcon: what is looked at, and what is found.
#pragma once
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace palpate::app {

enum class Health {
    OK,
    NOTE,  ///< works, could be better
    FAIL   ///< does not work like this
};

struct Finding {
    std::string name;
    Health health;
    std::string words;  ///< what was found
    std::string mend;   ///< what to do; empty when all is well
};

/// Where it looks. A test gives a folder of its own and its own answers.
struct Machine {
    std::filesystem::path root = "/";  ///< above etc, proc, sys, usr
    /// What palpate-falcon ARGUMENTS --json says; null when it says nothing.
    std::function<nlohmann::json(const std::vector<std::string>&)> ask_falcon;
    bool is_root = false;
    bool may_fifo = false;             ///< it was given the loop's real-time priority for a moment
    unsigned long rtprio_max = 0;      ///< RLIMIT_RTPRIO
    unsigned long memlock_bytes = 0;   ///< RLIMIT_MEMLOCK; ULONG_MAX: no limit
    unsigned long timer_slack_ns = 0;  ///< after asking for 1
    std::string kernel;                ///< uname -v
};

constexpr int LOOP_PRIORITY = 80;  ///< SCHED_FIFO, of palpate-loop

/// This machine.
[[nodiscard]] Machine this_machine();
[[nodiscard]] std::vector<Finding> examine(const Machine& machine);
/// Whether no finding is a FAIL.
[[nodiscard]] bool healthy(const std::vector<Finding>& findings);
[[nodiscard]] nlohmann::json findings_json(const std::vector<Finding>& findings);

/// Says what it would do to this machine's udev rules, asks, and does it only after "yes". The exit code: 0
/// installed or there already, 1 not.
int install_udev(const Machine& machine, std::istream& in, std::ostream& out);

}  // namespace palpate::app
