#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <climits>
#include <fstream>
#include <iostream>
#include <memory>

#include "host/app/child.hpp"
#include "host/app/commands.hpp"
#include "host/app/doctor.hpp"
#include "host/app/scratch.hpp"

namespace palpate::app {
namespace {

constexpr int ANSWER_MS = 10000;
constexpr const char* DOCTOR_FOOTER =
    "Examples:\n"
    "  palpate doctor                                      is this machine ready for a Falcon?\n"
    "  palpate doctor --install-udev                       give users the right to use it; asks first\n"
    "  palpate-falcon-sim run -- palpate doctor            the same without a Falcon\n"
    "\n"
    "fail: does not work like this. note: works, could be better. Exit code 1 when there is a fail.";

struct DoctorOptions {
    bool json = false, install = false;
};

/// What palpate-falcon says on stdout, as JSON; null when it says nothing of the kind.
nlohmann::json ask_falcon(const std::vector<std::string>& arguments) {
    const std::filesystem::path program = program_beside("palpate-falcon");
    if (access(program.c_str(), X_OK) != 0) return nullptr;
    const Scratch folder;
    std::vector<std::string> words{"-c", "exec \"$0\" \"$@\" --json 2> /dev/null", program.string()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    Child child("/bin/sh", words, folder / "answer");
    if (!child.wait(ANSWER_MS)) return nullptr;
    std::ifstream answer(folder / "answer");
    return nlohmann::json::parse(answer, nullptr, false);
}

unsigned long limit_of(__rlimit_resource resource) {
    rlimit limit{};
    if (getrlimit(resource, &limit) != 0) return 0;
    return limit.rlim_cur == RLIM_INFINITY ? ULONG_MAX : limit.rlim_cur;
}

/// Asks for the loop's priority, and puts back what was.
bool may_fifo() {
    sched_param before{}, wanted{};
    const int policy = sched_getscheduler(0);
    if (policy < 0 || sched_getparam(0, &before) != 0) return false;
    wanted.sched_priority = LOOP_PRIORITY;
    if (sched_setscheduler(0, SCHED_FIFO, &wanted) != 0) return false;
    sched_setscheduler(0, policy, &before);
    return true;
}

/// Asks for 1 ns as the loop does, and puts back what was.
unsigned long least_timer_slack_ns() {
    const int before_ns = prctl(PR_GET_TIMERSLACK, 0UL, 0UL, 0UL, 0UL);
    prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
    const int now_ns = prctl(PR_GET_TIMERSLACK, 0UL, 0UL, 0UL, 0UL);
    if (before_ns > 0) prctl(PR_SET_TIMERSLACK, static_cast<unsigned long>(before_ns), 0UL, 0UL, 0UL);
    return now_ns >= 0 ? static_cast<unsigned long>(now_ns) : ULONG_MAX;
}

void print(const std::vector<Finding>& findings) {
    for (const Finding& finding : findings) {
        const char* word = finding.health == Health::OK     ? "ok  "
                           : finding.health == Health::NOTE ? "note"
                                                            : "FAIL";
        std::cout << word << "  " << finding.name << ": " << finding.words << '\n';
        if (!finding.mend.empty()) std::cout << "      -> " << finding.mend << '\n';
    }
}

int doctor(const DoctorOptions& options) {
    const Machine machine = this_machine();
    if (options.install) return install_udev(machine, std::cin, std::cout);
    const std::vector<Finding> findings = examine(machine);
    if (options.json) {
        std::cout << findings_json(findings).dump(2) << '\n';
    } else {
        print(findings);
    }
    if (!std::cout.flush()) throw std::runtime_error("stdout cannot be written");
    return healthy(findings) ? 0 : 1;
}

}  // namespace

Machine this_machine() {
    Machine machine;
    machine.ask_falcon = ask_falcon;
    machine.is_root = geteuid() == 0;
    machine.may_fifo = may_fifo();
    machine.rtprio_max = limit_of(RLIMIT_RTPRIO);
    machine.memlock_bytes = limit_of(RLIMIT_MEMLOCK);
    machine.timer_slack_ns = least_timer_slack_ns();
    utsname name{};
    if (uname(&name) == 0) machine.kernel = name.version;
    return machine;
}

void add_doctor(CLI::App& palpate, std::function<int()>& chosen) {
    const auto options = std::make_shared<DoctorOptions>();
    CLI::App* command = palpate.add_subcommand("doctor", "is this machine ready for a Falcon; what to mend");
    command->add_flag("--install-udev", options->install,
                      "install the udev rule that lets users open the Falcon; asks first");
    command->add_flag("--json", options->json, "one JSON document on stdout");
    command->footer(DOCTOR_FOOTER);
    command->callback([options, &chosen] { chosen = [options] { return doctor(*options); }; });
}

}  // namespace palpate::app
