#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "common/link.h"
#include "host/latency/machine.hpp"

using namespace palpate::latency;

namespace {

namespace fs = std::filesystem;

/// A machine of files.
class Made {
public:
    explicit Made(const std::string& name) : root(fs::path(PAL_TEST_FOLDER) / name) { fs::remove_all(root); }
    void write(const std::string& file, const std::string& text) const {
        fs::create_directories((root / file).parent_path());
        std::ofstream(root / file) << text;
    }
    fs::path root;
};

}  // namespace

TEST_CASE("the facts of a machine are read from its files") {
    const Made made("machine");
    made.write("proc/cpuinfo",
               "processor\t: 0\nmodel name\t: Some CPU\n\nprocessor\t: 1\nmodel name\t: Some CPU\n");
    made.write("proc/sys/kernel/osrelease", "6.1.0-28-rt-amd64\n");
    made.write("proc/sys/kernel/version", "#1 SMP PREEMPT_RT Debian 6.1.119-1\n");
    made.write("proc/loadavg", "0.50 1.25 2.00 1/200 4242\n");
    made.write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n");
    made.write("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "powersave\n");
    made.write("sys/devices/system/cpu/cpuidle/current_driver", "intel_idle\n");
    made.write("sys/devices/system/cpu/cpuidle/current_governor_ro", "menu\n");
    const Machine machine = machine_facts(made.root);
    CHECK(machine.cpu == "Some CPU");
    CHECK(machine.n_cores == 2);
    CHECK(machine.kernel == "6.1.0-28-rt-amd64");
    CHECK(machine.real_time_kernel);
    CHECK(machine.preemption == "PREEMPT_RT");
    CHECK(machine.governor == "performance, powersave");
    CHECK(machine.idle_driver == "intel_idle, governor menu");
    CHECK(machine.load_1_min == 0.5);
    CHECK(machine.load_5_min == 1.25);
    REQUIRE(governors(made.root).size() == 2);
    CHECK(governors(made.root)[1].cpu == "cpu1");
    CHECK(governors(made.root)[1].name == "powersave");
}

TEST_CASE("a machine that says nothing is not known, not zero") {
    const Made made("silent");
    const Machine machine = machine_facts(made.root);
    CHECK(machine.cpu.empty());
    CHECK(machine.kernel.empty());
    CHECK(machine.preemption.empty());
    CHECK_FALSE(machine.real_time_kernel);
    CHECK(machine.governor.empty());
    CHECK(machine.idle_driver.empty());
    CHECK_FALSE(machine.load_1_min.has_value());
    CHECK_FALSE(stolen_s(made.root).has_value());
}

TEST_CASE("the kernel's preemption is named as far as it can be read") {
    const Made made("preemption");
    made.write("proc/sys/kernel/version", "#1 SMP PREEMPT_DYNAMIC x\n");
    CHECK(machine_facts(made.root).preemption == "PREEMPT_DYNAMIC, mode not readable");
    made.write("proc/cmdline", "quiet preempt=full ro\n");
    CHECK(machine_facts(made.root).preemption == "PREEMPT_DYNAMIC, full (command line)");
    made.write("sys/kernel/debug/sched/preempt", "none (voluntary) full\n");
    CHECK(machine_facts(made.root).preemption == "PREEMPT_DYNAMIC, voluntary");
    made.write("proc/sys/kernel/version", "#1 SMP x\n");
    CHECK(machine_facts(made.root).preemption == "none or voluntary");
    made.write("sys/kernel/realtime", "1\n");
    CHECK(machine_facts(made.root).preemption == "PREEMPT_RT");
    CHECK(is_real_time_kernel(made.root, ""));
}

TEST_CASE("stolen time is the eighth number of /proc/stat, in hundredths of a second") {
    const Made made("stolen");
    made.write("proc/stat", "cpu  1 2 3 4 5 6 7 250 9 10\ncpu0 1 1 1 1 1 1 1 1 1 1\n");
    CHECK(stolen_s(made.root) == 2.5);
    made.write("proc/stat", "cpu  1 2 3 4\n");
    CHECK_FALSE(stolen_s(made.root).has_value());
}

TEST_CASE("each step of getting real time is granted, refused or not asked for, in words") {
    const auto steps = realtime_steps(PAL_REALTIME_MEMORY_LOCKED | PAL_REALTIME_CPU, PAL_REALTIME_FIFO);
    REQUIRE(steps.size() == 7);
    std::string said;
    for (const RealtimeStep& step : steps) said += step.what + " " + word_of(step.outcome) + "\n";
    CHECK(said ==
          "locked memory granted\ntouched stack not asked for\ntimer slack of 1 ns not asked for\n"
          "one processor granted\nno deep sleep of the processors not asked for\nSCHED_FIFO refused\n"
          "SCHED_DEADLINE not asked for\n");
}
