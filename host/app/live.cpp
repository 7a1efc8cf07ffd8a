#include "host/app/live.hpp"

#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>
#include <utility>

#include "host/record/record.hpp"

namespace palpate::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int START_TIMEOUT_MS = 3000;
constexpr int ANSWER_TIMEOUT_MS = 2000;
constexpr int END_TIMEOUT_MS = 5000;        // of a loop that was asked to end: 20 packets of zero force
constexpr int TAKE_OVER_TIMEOUT_MS = 5000;  // the same of one that takes the device over
constexpr int NEIGHBOUR_MS = 200;  // a device that dies ends the loop too: time for its own end to show
constexpr auto REST_TIMEOUT = std::chrono::seconds(1);
// Looks, not time: a machine that stops everything for a while has stopped the looking too. The device's own
// watchdog has long acted by then.
constexpr int QUIET_LOOKS_MAX = 250;

std::string number(double value) {
    std::ostringstream out;
    out << value;
    return out.str();
}

std::string last_line(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::string line, last;
    while (std::getline(in, line)) {
        if (!line.empty()) last = line;
    }
    return last;
}

std::vector<std::string> loop_arguments(const LiveOptions& options, const std::string& device,
                                        const std::string& link) {
    std::vector<std::string> arguments{"--link",        link,
                                       "--device",      device,
                                       "--force-max-n", number(options.force_max_n),
                                       "--ramp-ticks",  std::to_string(options.ramp_ticks)};
    if (!options.firmware.empty()) arguments.insert(arguments.end(), {"--firmware", options.firmware});
    if (!options.delta.empty()) arguments.insert(arguments.end(), {"--delta", options.delta});
    arguments.insert(arguments.end(), options.loop_arguments.begin(), options.loop_arguments.end());
    return arguments;
}

}  // namespace

std::string refusal_of_device(const std::string& device) {
    const bool known =
        device == "sim" || device == "usb" || (device.starts_with("usb:") && device.size() > 4);
    return known ? "" : "sim, usb or usb:SERIAL is expected, not " + device;
}

void require_firmware(const LiveOptions& options, const Scratch& scratch) {
    if (options.device == "sim") return;
    std::vector<std::string> arguments{"firmware"};
    if (!options.firmware.empty()) arguments.insert(arguments.end(), {"--firmware", options.firmware});
    const std::filesystem::path answer = scratch / "firmware";
    Child asker(program_beside("palpate-falcon"), arguments, answer);
    if (asker.wait(ANSWER_TIMEOUT_MS) && asker.ended() == "exit 0") return;
    std::string words = last_line(answer);
    const std::string name = "palpate-falcon: ";
    if (words.starts_with(name)) words.erase(0, name.size());
    throw LiveInputError(words.empty() ? "palpate-falcon does not say whether the firmware can be used"
                                       : words);
}

Live::Live(LiveOptions options, const Scratch& scratch, std::filesystem::path log,
           const link::Salvage& salvage)
    : options_(std::move(options)), scratch_(&scratch), log_(std::move(log)), segment_(salvage) {
    if (simulated()) start_device();
    pal_link_store(&link().host.enable, 1);
    loop_.emplace(program_beside("palpate-loop"), loop_arguments(options_, device_argument(), segment_name()),
                  log_);
}

void Live::start_device() {
    std::vector<std::string> arguments{"serve", "--socket", (*scratch_ / "falcon").string(),
                                       "--die-with-parent"};
    arguments.insert(arguments.end(), options_.sim_arguments.begin(), options_.sim_arguments.end());
    device_.emplace(program_beside("palpate-falcon-sim"), arguments, log_);
    for (int waited = 0; !std::filesystem::exists(*scratch_ / "falcon.control"); waited += 5) {
        if (const auto how = device_->ended())
            throw ChildError("palpate-falcon-sim ended at once (" + *how + "): " + last_line(log_));
        if (waited > START_TIMEOUT_MS)
            throw ChildError("palpate-falcon-sim did not open its socket within 3 s");
        usleep(5000);
    }
    std::ofstream(log_, std::ios::app)
        << "palpate: the device's socket is " << (*scratch_ / "falcon").string() << '\n';
}

std::string Live::device_argument() const {
    return simulated() ? "link:" + (*scratch_ / "falcon").string() : options_.device;
}

bool Live::stands_still() {
    const std::uint32_t tick = pal_link_load(&link().loop.heartbeat);
    const bool moves = tick != tick_seen_ || tick == 0;  // 0: it has not begun, as while a device boots
    tick_seen_ = tick;
    quiet_looks_ = moves ? 0 : quiet_looks_ + 1;
    return quiet_looks_ >= QUIET_LOOKS_MAX;
}

std::string Live::failure() {
    const auto loop_end = loop_->ended();
    if (loop_end && device_) device_->wait(NEIGHBOUR_MS);
    if (device_) {
        if (const auto how = device_->ended())
            return "palpate-falcon-sim ended in mid-run (" + *how + "); see log.txt";
    }
    if (loop_end && pal_link_load(&link().loop.heartbeat) == 0)
        return "palpate-loop ended before its first tick (" + *loop_end + "): " + last_line(log_);
    if (loop_end) {
        const std::uint32_t reason = pal_link_load(&link().loop.end_reason);
        const std::string why = reason != 0 ? ", " + record::fault_words(reason) : "";
        return "palpate-loop ended in mid-run (" + *loop_end + why + "); see log.txt";
    }
    if (!stands_still()) return "";
    kill(loop_->pid(), SIGKILL);
    loop_->wait(NEIGHBOUR_MS);
    stood_still_ = true;
    return "palpate-loop stood still at tick " + std::to_string(tick_seen_) + " and was killed";
}

TakeOver Live::take_over() {
    if (pal_link_load(&link().loop.ended) != 0)
        return {.done = true, .words = "the loop sent zero force itself"};
    if (simulated() && device_->ended()) return {.words = "the device is gone"};
    const auto begun = Clock::now();
    Child zero(program_beside("palpate-loop"), {"--zero", "--device", device_argument()}, log_);
    const bool in_time = zero.wait(TAKE_OVER_TIMEOUT_MS);
    const double took_s = std::chrono::duration<double>(Clock::now() - begun).count();
    if (in_time && zero.ended() == "exit 0") return {true, took_s, "palpate sent zero force in its place"};
    return {false, took_s, "zero force could not be sent (" + zero.ended().value_or("no end") + ")"};
}

bool Live::stop() {
    pal_link_store(&link().host.stop, 1);
    return loop_->wait(END_TIMEOUT_MS);
}

std::string Live::ask_device() const {
    const std::filesystem::path answer = *scratch_ / "status";
    std::filesystem::remove(answer);
    Child asker(program_beside("palpate-falcon-sim"), {"status", "--socket", (*scratch_ / "falcon").string()},
                answer);
    asker.wait(ANSWER_TIMEOUT_MS);
    return asker.ended() == "exit 0" ? last_line(answer) : "";
}

std::string Live::device_at_rest() const {
    if (!simulated()) return "";
    const auto until = Clock::now() + REST_TIMEOUT;
    std::string status = ask_device();
    while (!status.empty() && status.find("\"motor_counts\":[0,0,0]") == std::string::npos &&
           Clock::now() < until) {
        status = ask_device();
    }
    return status.empty() ? "{\"no_answer\": true}" : status;
}

}  // namespace palpate::app
