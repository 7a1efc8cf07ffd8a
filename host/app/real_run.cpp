#include <unistd.h>

#include <chrono>
#include <cmath>
#include <exception>
#include <fstream>
#include <sstream>
#include <thread>

#include "host/app/child.hpp"
#include "host/app/interrupt.hpp"
#include "host/app/run.hpp"
#include "host/app/scratch.hpp"
#include "host/app/table_thread.hpp"
#include "host/link/segment.hpp"

namespace palpate::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int START_TIMEOUT_MS = 3000;
constexpr int ANSWER_TIMEOUT_MS = 2000;
constexpr int END_TIMEOUT_MS = 5000;  // of a loop that was asked to end: 20 packets of zero force
constexpr int NEIGHBOUR_MS = 200;     // a device that dies ends the loop too: time for its own end to show
constexpr auto REST_TIMEOUT = std::chrono::seconds(1);
constexpr auto LOOK_EVERY = std::chrono::milliseconds(2);
constexpr std::uint32_t HOMING_TICKS_MAX = 10000;

std::string millionths(double value) {
    return std::to_string(std::llround(1e6 * value));
}

void write_path(const std::filesystem::path& file, const std::vector<DevicePoint>& path) {
    std::ofstream out(file);
    out << "palpate-path 1\n";
    for (const DevicePoint& p : path) {
        out << millionths(p.t_s) << ' ' << millionths(p.at_m[0]) << ' ' << millionths(p.at_m[1]) << ' '
            << millionths(p.at_m[2]) << '\n';
    }
    if (!out) throw std::runtime_error(file.string() + ": cannot be written");
}

std::string number(double value) {
    std::ostringstream out;
    out << value;
    return out.str();
}

std::vector<std::string> device_arguments(const scene::Scene& scene, const Scratch& scratch) {
    const scene::Hand& hand = scene.hand;
    return {
        "serve",
        "--socket",
        (scratch / "falcon").string(),
        "--path",
        (scratch / "path").string(),
        "--grip",
        number(hand.mass_kg) + "," + number(hand.stiffness_n_per_m) + "," + number(hand.damping_n_s_per_m),
        "--ramp-ticks",
        std::to_string(std::max(1L, std::lround(1e3 * scene.touch.ramp_s))),
        "--seed",
        std::to_string(scene.run.seed),
        "--die-with-parent"};
}

std::vector<std::string> loop_arguments(const scene::Scene& scene, const Scratch& scratch,
                                        const std::string& link) {
    return {"--link",        link,
            "--device",      "link:" + (scratch / "falcon").string(),
            "--force-max-n", number(scene.touch.force_max_n),
            "--ramp-ticks",  std::to_string(std::lround(1e3 * scene.touch.ramp_s))};
}

std::string last_line(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::string line, last;
    while (std::getline(in, line)) {
        if (!line.empty()) last = line;
    }
    return last;
}

/// What the simulated Falcon says of itself, one JSON line; empty when nobody answers.
std::string ask_device(const Scratch& scratch) {
    const std::filesystem::path answer = scratch / "status";
    std::filesystem::remove(answer);
    Child asker(program_beside("palpate-falcon-sim"), {"status", "--socket", (scratch / "falcon").string()},
                answer);
    asker.wait(ANSWER_TIMEOUT_MS);
    return asker.ended() == "exit 0" ? last_line(answer) : "";
}

/// Likewise once its motors are off: a loop that was killed sends no zero force, then the device's own
/// watchdog switches them off after 100 ms.
std::string device_at_rest(const Scratch& scratch) {
    const auto until = Clock::now() + REST_TIMEOUT;
    std::string status = ask_device(scratch);
    while (!status.empty() && status.find("\"motor_counts\":[0,0,0]") == std::string::npos &&
           Clock::now() < until) {
        status = ask_device(scratch);
    }
    return status.empty() ? "{\"no_answer\": true}" : status;
}

/// What ended the building of tables, in words; empty while nothing did.
std::string why_no_more_tables(const std::exception_ptr& failure) {
    if (!failure) return "";
    try {
        std::rethrow_exception(failure);
    } catch (const std::exception& error) {
        return std::string("building a table failed: ") + error.what();
    }
}

/// Reads the loop's records and numbers the path's ticks: the path begins a ramp after homing, here as in the
/// device.
class Watcher {
public:
    Watcher(const pal_link& link, std::uint32_t ramp_ticks) : link_(&link), ramp_ticks_(ramp_ticks) {}
    /// Appends what is new; the newest record, if any.
    const pal_tick* drain(std::vector<pal_tick>& ticks) {
        const std::size_t before = ticks.size();
        pal_tick record{};
        while (pal_state_ring_read(&link_->ticks, &reader_, &record)) {
            if (homed_tick_ == 0 && record.state != PAL_STATE_HOMING && record.state != PAL_STATE_DISABLED) {
                homed_tick_ = record.tick;
            }
            const std::uint32_t begun = homed_tick_ + ramp_ticks_;
            if (homed_tick_ != 0 && record.tick > begun) record.path_tick = record.tick - begun;
            ticks.push_back(record);
        }
        return ticks.size() > before ? &ticks.back() : nullptr;
    }

private:
    const pal_link* link_;
    std::uint32_t ramp_ticks_, homed_tick_ = 0;
    pal_state_reader reader_{};
};

/// Ticks per second over the last half second or so.
class Rate {
public:
    double now(std::size_t n_ticks) {
        const auto at = Clock::now();
        const double s = std::chrono::duration<double>(at - since_).count();
        if (s > 0.5) {
            hz_ = static_cast<double>(n_ticks - n_) / s;
            since_ = at;
            n_ = n_ticks;
        }
        return hz_;
    }

private:
    Clock::time_point since_ = Clock::now();
    std::size_t n_ = 0;
    double hz_ = 0.0;
};

void wait_for_device(Child& device, const Scratch& scratch, const std::filesystem::path& log) {
    for (int waited = 0; waited < START_TIMEOUT_MS; waited += 5) {
        if (std::filesystem::exists(scratch / "falcon.control")) return;  // the last of its two sockets
        if (const auto how = device.ended()) {
            throw ChildError("palpate-falcon-sim ended at once (" + *how + "): " + last_line(log));
        }
        usleep(5000);
    }
    throw ChildError("palpate-falcon-sim did not open its socket within 3 s");
}

/// Which program ended in mid-run, how, and why as far as is known; empty while both run.
std::string who_ended(Child& device, Child& loop, const pal_link& link) {
    const auto loop_end = loop.ended();
    if (loop_end) device.wait(NEIGHBOUR_MS);
    if (const auto how = device.ended())
        return "palpate-falcon-sim ended in mid-run (" + *how + "); see log.txt";
    if (!loop_end) return "";
    const std::uint32_t reason = pal_link_load(&link.loop.end_reason);
    return "palpate-loop ended in mid-run (" + *loop_end +
           (reason != 0 ? ", " + record::fault_words(reason) : "") + "); see log.txt";
}

bool finished(const std::vector<pal_tick>& ticks, std::uint32_t path_ticks) {
    if (ticks.empty()) return false;
    return ticks.back().path_tick > path_ticks ||
           (ticks.back().path_tick == 0 && ticks.back().tick > HOMING_TICKS_MAX);
}

}  // namespace

RunResult run_real(const Prepared& prepared, const Operator& rig, Progress& progress, const Scratch& scratch,
                   const std::filesystem::path& log) {
    const scene::Scene& scene = prepared.world->scene;
    const link::Segment segment;
    pal_link& link = segment.link();
    write_path(scratch / "path", device_path(*prepared.world));
    Child device(program_beside("palpate-falcon-sim"), device_arguments(scene, scratch), log);
    wait_for_device(device, scratch, log);
    std::ofstream(log, std::ios::app)
        << "palpate: the device's socket is " << (scratch / "falcon").string() << '\n';
    pal_link_store(&link.host.enable, 1);
    RunResult result;
    result.start_unix_ns =
        static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch().count());
    result.start_monotonic_ns = monotonic_ns();
    Child loop(program_beside("palpate-loop"), loop_arguments(scene, scratch, segment.name()), log);
    table::Server server(*prepared.world, *prepared.field, prepared.options);
    TableThread tables([&server](const pal_tick& record) { return server.update(record); }, link);
    Watcher watcher(link, static_cast<std::uint32_t>(std::lround(1e3 * scene.touch.ramp_s)));
    Rate rate;
    for (std::uint32_t beat = 1; !finished(result.ticks, path_ticks(*prepared.world)); ++beat) {
        pal_link_store(&link.host.heartbeat, beat);
        pal_link_store(&link.host.enable, rig.enable() ? 1 : 0);
        if (rig.estop()) pal_link_store(&link.host.estop, 1);
        if (const pal_tick* newest = watcher.drain(result.ticks)) {
            tables.offer(*newest);
            const double hz = rate.now(result.ticks.size());
            rig.show(*newest, hz);
            progress.show("real time  " + status_line(*newest, hz));
        }
        result.failure = who_ended(device, loop, link);
        if (result.failure.empty()) result.failure = why_no_more_tables(tables.failure());
        if (!result.failure.empty()) break;
        if (interrupted()) {
            result.interrupted = true;
            break;
        }
        std::this_thread::sleep_for(LOOK_EVERY);
    }
    pal_link_store(&link.host.stop, 1);  // before the table at work is waited for: the force ends now
    tables.stop();
    if (!loop.wait(END_TIMEOUT_MS) && result.failure.empty())
        result.failure = "palpate-loop did not end when asked to";
    watcher.drain(result.ticks);
    result.end_monotonic_ns = monotonic_ns();
    result.device_status = device_at_rest(scratch);
    result.tables = tables.tables();
    result.n_tables_built = server.n_built();
    result.n_tables_refused = server.n_refused();
    result.refused_by_check = tables.refused();
    const bool homed = !result.ticks.empty() && result.ticks.back().path_tick > 0;
    if (result.failure.empty() && !result.interrupted && !homed)
        result.failure = "the device did not home within 10 s";
    result.no_tables = why_no_tables(prepared, result);
    return result;
}

}  // namespace palpate::app
