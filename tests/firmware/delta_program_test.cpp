// --delta of palpate-falcon and palpate-loop, as people start them.
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "common/link.h"
#include "common/state_ring.h"
#include "tests/firmware/delta_text.hpp"
#include "tests/firmware/usb_bench.hpp"

using namespace usbbench;
using Catch::Matchers::Contains;
using usbtest::Bus;
using usbtest::Outcome;
using usbtest::Process;

namespace {

std::string write(const Folder& folder, const std::string& text) {
    std::ofstream(folder / "delta.toml") << text;
    return folder / "delta.toml";
}

/// Where the monitor sees a resting simulated Falcon, in metres; `more` are its further arguments.
std::vector<double> monitored_m(const Folder& folder, std::vector<std::string> more) {
    more.insert(more.begin(), {"monitor", "--json", "--seconds", "3", "--firmware", folder.firmware()});
    const Outcome outcome =
        run_falcon({"--timing", "immediate", "--grip", "firm", "--ramp-ticks", "100"}, more);
    INFO(outcome.words);
    const std::size_t at = outcome.words.rfind("\"position_m\": ");
    REQUIRE(at != std::string::npos);
    const std::size_t begin = outcome.words.find('[', at);
    return json::parse(outcome.words.substr(begin, outcome.words.find(']', at) - begin + 1));
}

/// The end of a run of palpate-loop on a simulated Falcon: its last tick, and all faults since forces were
/// on.
struct Run {
    pal_tick last{};
    std::uint32_t faults = 0;
    bool enabled = false;
};

/// Beats and reads until forces have been on for `n_ticks`; gives up after a limit that no healthy run
/// reaches.
Run watch(pal_link& link, std::uint32_t n_ticks) {
    Run run;
    pal_state_reader reader{};
    pal_tick record{};
    std::uint32_t n_on = 0;
    for (std::uint32_t look = 1; look < 8000 && n_on < n_ticks; ++look) {
        pal_link_store(&link.host.heartbeat, look);
        while (pal_state_ring_read(&link.ticks, &reader, &record)) {
            run.last = record;
            n_on = record.state == PAL_STATE_ENABLED ? n_on + 1 : 0;
            run.faults = n_on == 0 ? 0 : run.faults | record.faults;
        }
        poll(nullptr, 0, 2);
    }
    run.enabled = n_on >= n_ticks;
    return run;
}

Run loop_on_usb(const Folder& folder, const std::vector<std::string>& more) {
    const std::string name = "/palpate-delta-" + std::to_string(getpid());
    const int file = shm_open(name.c_str(), O_CREAT | O_EXCL | O_RDWR, 0600);
    REQUIRE(file >= 0);
    REQUIRE(ftruncate(file, sizeof(pal_link)) == 0);
    void* at = mmap(nullptr, sizeof(pal_link), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    close(file);
    REQUIRE(at != MAP_FAILED);
    auto& link = *static_cast<pal_link*>(at);
    pal_link_init(&link, 7);
    pal_link_store(&link.host.enable, 1);
    Run run;
    {
        std::ofstream(folder / "path") << "palpate-path 1\n0 20000 -10000 100000\n";
        const Bus bus(
            {"--timing", "immediate", "--grip", "firm", "--path", folder / "path", "--ramp-ticks", "100"});
        std::vector<std::string> words{usbtest::client("palpate-loop"), "--link", name, "--device", "usb"};
        words.insert(words.end(), {"--firmware", folder.firmware(), "--ramp-ticks", "20"});
        words.insert(words.end(), more.begin(), more.end());
        Process loop(words, Bus::environment());
        run = watch(link, 1000);
        pal_link_store(&link.host.stop, 1);
        INFO(loop.words());
        CHECK(loop.wait() == 0);
    }
    munmap(at, sizeof(pal_link));
    shm_unlink(name.c_str());
    return run;
}

}  // namespace

TEST_CASE("palpate-loop moves in the workspace of the file's delta", "[process]") {
    const Folder folder;
    const Run built_in = loop_on_usb(folder, {});
    const Run twice = loop_on_usb(folder, {"--delta", write(folder, deltatext::scaled(2.0))});
    REQUIRE(built_in.enabled);
    REQUIRE(twice.enabled);
    CHECK((twice.faults & PAL_FAULT_WORKSPACE) == 0);
    const float held_m[3] = {0.02F, -0.01F,
                             -0.02F};  // by the hand, which gives way by less than a millimetre
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(built_in.last.position_m[i] == Approx(held_m[i]).margin(1e-3));
        CHECK(twice.last.position_m[i] == Approx(2.0F * held_m[i]).margin(2e-3));
    }
}

TEST_CASE("force-check is good for a delta twice as large, whose words are twice as large", "[process]") {
    const Folder folder;
    const std::string file = write(folder, deltatext::scaled(2.0));
    const Outcome outcome = usbtest::call({falcon(), "force-check", "--json", "--delta", file});
    INFO(outcome.words);
    CHECK(outcome.code == 0);
    const json document = json::parse(outcome.words);
    CHECK(document["good"] == true);
    REQUIRE(document["rows"].size() == 24);
    const json& row = document["rows"][5];
    CHECK(row["position_m"][2].get<double>() == Approx(0.22));
    // 4 N / 3 / (13.785 rad/m / 2) times -4200 units per N m.
    CHECK(row["motor_counts"] == json::array({-812, -812, -812}));
}

TEST_CASE("force-check asks a weak delta for no more than its motor words can say", "[process]") {
    const Folder folder;
    const std::string file = write(folder, deltatext::with("motor_max_units", "300"));
    const Outcome outcome = usbtest::call({falcon(), "force-check", "--json", "--delta", file});
    CHECK(outcome.code == 0);
    const json row = json::parse(outcome.words)["rows"][5];
    CHECK(row["motor_counts"] == json::array({-300, -300, -300}));
    CHECK(row["wanted_n"][2].get<double>() == Approx(300.0 / 4200.0 * 13.785 * 3.0).epsilon(1e-4));
}

TEST_CASE("the monitor sees a Falcon through the file's geometry", "[process]") {
    const Folder folder;
    const std::vector<double> built_in_m = monitored_m(folder, {});
    const std::vector<double> file_m = monitored_m(folder, {"--delta", PAL_NF1_TOML});
    const std::vector<double> twice_m =
        monitored_m(folder, {"--delta", write(folder, deltatext::scaled(2.0))});
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(file_m[i] == Approx(built_in_m[i]).margin(1e-4));
        CHECK(twice_m[i] == Approx(2.0 * built_in_m[i]).margin(2e-4));
    }
}

TEST_CASE("a bad delta file ends both programs with its line and code 2", "[process]") {
    const Folder folder;
    const std::string file = write(folder, deltatext::with("arm_m", "60"));
    const std::string words = file + ":1: arm_m: 60 is out of range; expected 0.005 to 1\n";
    for (const char* command : {"force-check", "home", "monitor", "rate"}) {
        const Outcome outcome = usbtest::call({falcon(), command, "--delta", file});
        CAPTURE(command);
        CHECK(outcome.code == 2);
        CHECK(outcome.words == "palpate-falcon: " + words);
    }
    const Outcome loop = usbtest::call(
        {usbtest::client("palpate-loop"), "--link", "/none", "--device", "usb", "--delta", file});
    CHECK(loop.code == 2);
    CHECK(loop.words == "palpate-loop: " + words);
    CHECK_THAT(usbtest::call({usbtest::client("palpate-loop"), "--help"}).words, Contains("--delta FILE"));
    CHECK_THAT(usbtest::call({falcon(), "--help"}).words, Contains("--delta FILE"));
}
