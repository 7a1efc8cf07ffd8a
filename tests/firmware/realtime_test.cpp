// What palpate-loop asks of the system before its first tick, what it is given, and what disturbs it then.
#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>
#include <sstream>

#include "tests/firmware/loop_host.hpp"
#include "tests/lacking.hpp"

using namespace loophost;
using Catch::Matchers::Contains;

namespace {

constexpr std::uint32_t ALWAYS = PAL_REALTIME_TIMER_SLACK | PAL_REALTIME_STACK_TOUCHED;

std::uint32_t n_ticks() {
    return usbtest::soak() ? 60000 : 3000;
}

struct Granted {
    std::uint32_t granted, refused;
    std::string words;
};

/// Until its first ticks, then asked to end.
Granted granted_to(Host& host, std::vector<std::string> argv) {
    Process loop(std::move(argv));
    REQUIRE(host.comes_to(PAL_STATE_ENABLED));
    const pal_link_loop& words = host.link().loop;
    Granted result{pal_link_load(&words.realtime), pal_link_load(&words.realtime_refused), ""};
    pal_link_store(&host.link().host.stop, 1);
    result.words = loop.words();
    CHECK(loop.wait() == 0);
    pal_link_store(&host.link().host.stop, 0);
    return result;
}

/// The loop without any of root's rights.
std::vector<std::string> without_rights(const std::vector<std::string>& loop) {
    std::vector<std::string> argv;
    if (geteuid() == 0) argv = {"setpriv", "--bounding-set=-all", "--inh-caps=-all"};
    argv.insert(argv.end(), {"prlimit", "--memlock=65536:65536", "--rtprio=0:0"});
    argv.insert(argv.end(), loop.begin(), loop.end());
    return argv;
}

long locked_kb(pid_t pid) {
    std::ifstream status("/proc/" + std::to_string(pid) + "/status");
    std::string word;
    while (status >> word && word != "VmLck:") {
    }
    long n_kb = 0;
    status >> n_kb;
    return n_kb;
}

int lines_in(const std::string& words, const std::string& piece) {
    std::istringstream in(words);
    std::string line;
    int n = 0;
    while (std::getline(in, line)) n += line.find(piece) != std::string::npos ? 1 : 0;
    return n;
}

}  // namespace

TEST_CASE("without rights the loop runs all the same, and says once what is refused and how to get it",
          "[process]") {
    const Falcon falcon;
    Host host;
    const Granted none = granted_to(host, without_rights(loophost::loop(host)));
    INFO(none.words);
    CHECK((none.granted & ALWAYS) == ALWAYS);
    CHECK((none.refused & (PAL_REALTIME_MEMORY_LOCKED | PAL_REALTIME_FIFO)) ==
          (PAL_REALTIME_MEMORY_LOCKED | PAL_REALTIME_FIFO));
    CHECK((none.granted & none.refused) == 0);
    CHECK(((none.granted | none.refused) & (PAL_REALTIME_CPU | PAL_REALTIME_DEADLINE)) == 0);
    CHECK(lines_in(none.words, "no locked memory (") == 1);
    CHECK(lines_in(none.words, "ulimit -l unlimited") == 1);
    CHECK(lines_in(none.words, "no real-time priority (SCHED_FIFO) (") == 1);
    CHECK(lines_in(none.words, "rtprio 99") == 1);
    CHECK(lines_in(none.words, "carrying on without it") == __builtin_popcount(none.refused));
    CHECK(lines_in(none.words, "") == __builtin_popcount(none.refused));
}

TEST_CASE("what is not asked for is neither granted nor refused, nor spoken of", "[process]") {
    const Falcon falcon;
    Host host;
    const Granted least =
        granted_to(host, without_rights(loophost::loop(host, {"--policy", "other", "--no-lock"})));
    CHECK(((least.granted | least.refused) & ~(ALWAYS | PAL_REALTIME_CPU_LATENCY)) == 0);
    CHECK_THAT(least.words, !Contains("locked memory") && !Contains("SCHED_"));
}

TEST_CASE("each step that this machine grants is in force in the tick's thread", "[process]") {
    const Falcon falcon;
    Host host;
    const std::string policy = GENERATE(as<std::string>{}, "fifo", "deadline");
    std::vector<std::string> more = {"--policy", policy};
    if (policy == "fifo") more.insert(more.end(), {"--priority", "42", "--cpu", "0"});
    Process loop(loophost::loop(host, more));
    REQUIRE(host.comes_to(PAL_STATE_ENABLED));
    const pal_link_loop& words = host.link().loop;
    const auto pid = static_cast<pid_t>(pal_link_load(&words.pid));
    const std::uint32_t granted = pal_link_load(&words.realtime);
    if ((granted & PAL_REALTIME_FIFO) != 0) {
        sched_param given{};
        CHECK(sched_getscheduler(pid) == SCHED_FIFO);
        CHECK(sched_getparam(pid, &given) == 0);
        CHECK(given.sched_priority == 42);
    }
    if ((granted & PAL_REALTIME_DEADLINE) != 0) CHECK(sched_getscheduler(pid) == 6);
    if ((granted & PAL_REALTIME_MEMORY_LOCKED) != 0)
        CHECK(locked_kb(pid) > 1024);  // the segment alone is 1236
    if ((granted & PAL_REALTIME_CPU) != 0) {
        cpu_set_t where;
        REQUIRE(sched_getaffinity(pid, sizeof where, &where) == 0);
        CHECK(CPU_COUNT(&where) == 1);
        CHECK(CPU_ISSET(0, &where));
    }
    if ((granted & (PAL_REALTIME_FIFO | PAL_REALTIME_DEADLINE)) == 0)
        palpate::test::lacking("the right to " + policy);
    // The helper, the second thread, has none of it.
    for (const auto& entry : std::filesystem::directory_iterator("/proc/" + std::to_string(pid) + "/task")) {
        const auto thread = static_cast<pid_t>(std::stol(entry.path().filename()));
        if (thread != pid) CHECK(sched_getscheduler(thread) == SCHED_OTHER);
    }
    pal_link_store(&host.link().host.stop, 1);
    CHECK(loop.wait() == 0);
}

TEST_CASE("a processor that does not exist is an error, not a missing right", "[process]") {
    Host host;
    const usbtest::Outcome outcome = usbtest::call(loophost::loop(host, {"--cpu", "4000"}));
    CHECK(outcome.code == 2);
    CHECK_THAT(outcome.words, Contains("--cpu 4000: this machine has processors 0 to "));
}

TEST_CASE("with locked memory no tick takes a page fault", "[process]") {
    const Falcon falcon;
    Host host;
    host.offer_skin();
    Process loop(loophost::loop(host));
    REQUIRE(host.is_pressed());
    const pal_link_loop& words = host.link().loop;
    for (std::uint32_t n = 1000; n <= n_ticks(); n += 1000) {
        REQUIRE(host.until([&] { return pal_link_load(&words.heartbeat) >= n; }));
    }
    pal_link_store(&host.link().host.stop, 1);
    CHECK(loop.wait() == 0);
    CHECK(pal_link_load(&words.ended) == 1);
    if ((pal_link_load(&words.realtime) & PAL_REALTIME_MEMORY_LOCKED) == 0)
        return palpate::test::lacking("the right to lock memory");
    CHECK(pal_link_load(&words.n_minor_faults) == 0);
    CHECK(pal_link_load(&words.n_major_faults) == 0);
}

TEST_CASE("a tick's thread that has to share its processor says so", "[process]") {
    const Falcon falcon;
    Host host;
    // Two at the lowest of all priorities on one processor that something else wants, too.
    Process busy({"taskset", "-c", "0", "sh", "-c", "while :; do :; done"});
    std::vector<std::string> argv = {"nice", "-n", "19"};
    const std::vector<std::string> loop_argv =
        loophost::loop(host, {"--policy", "other", "--cpu", "0", "--no-lock"});
    argv.insert(argv.end(), loop_argv.begin(), loop_argv.end());
    Process loop(argv);
    const pal_link_loop& words = host.link().loop;
    CHECK(host.until([&] { return pal_link_load(&words.n_preempted) > 0; }));
    pal_link_store(&host.link().host.stop, 1);
    CHECK(loop.wait() == 0);
}
